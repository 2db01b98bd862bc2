// Reads mutated files in this process, under sanitizers (libFuzzer):
//   fuzz_inputs NAME [options of libFuzzer] CORPUS    reads files made of those in the folder
//   fuzz_inputs NAME seeds FOLDER                     writes the files to begin with
//   fuzz_inputs names                                  lists the readers; so does fuzz_runs its own
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "bench/fuzz/reader.h"
#include "datasets/store/input_error.h"

namespace {

using graintruth::fuzz::Reader;

struct Target {
  Reader reader;
  std::filesystem::path file;  // in memory where there is such a folder
} target;

void write(const std::filesystem::path& file, const char* data, std::size_t size) {
  std::ofstream(file, std::ios::binary).write(data, static_cast<std::streamsize>(size));
}

void remove_files() {
  std::error_code ignored;
  std::filesystem::remove_all(target.file.parent_path(), ignored);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  const std::vector<Reader> readers = graintruth::fuzz::readers();
  const std::string name = *count > 1 ? (*arguments)[1] : "names";
  for (const Reader& reader : readers) {
    if (name == "names") std::printf("%s\n", reader.name.c_str());
    if (reader.name == name) target.reader = reader;
  }
  if (name == "names") std::exit(0);
  if (!target.reader.read) {
    std::fprintf(stderr, "%s is no reader\n", name.c_str());
    std::exit(2);
  }
  if (*count == 4 && std::string((*arguments)[2]) == "seeds") {
    const std::filesystem::path folder = (*arguments)[3];
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const std::string& seed : target.reader.seeds)
      write(folder / ("seed" + std::to_string(number++)), seed.data(), seed.size());
    std::exit(0);
  }
  // libFuzzer does not know the first argument.
  (*arguments)[1] = (*arguments)[0];
  ++*arguments;
  --*count;
  const std::filesystem::path memory = "/dev/shm";
  const std::filesystem::path folder =
      (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
      ("graintruth-fuzz-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  target.file = folder / ("input" + target.reader.extension);
  std::atexit(remove_files);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  write(target.file, reinterpret_cast<const char*>(data), size);
  try {
    target.reader.read(target.file);
  } catch (const graintruth::datasets::InputError& error) {
    const std::string sentence = error.what();
    // A refusal is one line that ends as a sentence does.
    if (sentence.find('\n') != std::string::npos) throw std::logic_error(sentence);
  }
  return 0;
}
