#include "datasets/store/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

[[noreturn]] void refuse_write(const std::filesystem::path& file, int error) {
  throw InputError(fmt::format("{}: cannot be written ({}); choose another folder with --out.",
                               file.string(),
                               std::strerror(error)));
}

}  // namespace

std::filesystem::path RunFolder::table(std::string_view name) const {
  return root / "tables" / fmt::format("{}.csv", name);
}

std::filesystem::path RunFolder::unfinished_table(std::string_view name) const {
  return root / "tables" / fmt::format("{}.unfinished.csv", name);
}

std::filesystem::path RunFolder::tracks(std::string_view replicate) const {
  return root / "tracks" / fmt::format("{}.csv", replicate);
}

std::filesystem::path RunFolder::film_table(std::string_view replicate,
                                            std::string_view name) const {
  return root / "tracks" / fmt::format("{}.{}.csv", replicate, name);
}

std::filesystem::path RunFolder::overlay(std::string_view replicate) const {
  return root / "tracks" / fmt::format("{}.overlay.mp4", replicate);
}

std::filesystem::path RunFolder::annotated_frame(std::string_view replicate,
                                                 std::string_view moment) const {
  return root / "tracks" / fmt::format("{}.{}.jpg", replicate, moment);
}

std::filesystem::path RunFolder::side_by_side_still(std::size_t number) const {
  return root / "side_by_side" / fmt::format("{:02}.jpg", number);
}

std::filesystem::path RunFolder::tracking_of(std::string_view replicate) const {
  return root / "tracks" / fmt::format("{}.json", replicate);
}

RunFolder open_run_folder(const std::filesystem::path& root) {
  const RunFolder folder{root};
  for (const auto& made : {root, root / "tables", root / "tracks"}) make_folder(made);
  const std::filesystem::path probe = root / ".write-probe";
  write_whole(probe, "");
  std::filesystem::remove(probe);
  return folder;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) refuse_write(folder, error.value());
}

void remove_unfinished(const RunFolder& folder) {
  for (const std::filesystem::path& place : {folder.root,
                                             folder.table("").parent_path(),
                                             folder.tracks("").parent_path(),
                                             folder.side_by_side_still(0).parent_path()}) {
    std::error_code error;
    std::vector<std::filesystem::path> unfinished;
    for (const auto& entry : std::filesystem::directory_iterator(place, error)) {
      const std::filesystem::path& file = entry.path();
      if (file.extension() == ".unfinished" || file.stem().extension() == ".unfinished")
        unfinished.push_back(file);
    }
    for (const std::filesystem::path& file : unfinished) std::filesystem::remove(file, error);
  }
}

void remove_progress(const RunFolder& folder) {
  std::error_code absent;
  std::filesystem::remove(folder.progress(), absent);
  std::filesystem::remove(folder.unfinished_table("evaluations"), absent);
}

void write_whole(const std::filesystem::path& file, std::string_view content) {
  const std::filesystem::path unfinished = file.string() + ".unfinished";
  const int descriptor = ::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) refuse_write(file, errno);
  std::size_t done = 0;
  int error = 0;
  while (done < content.size() && error == 0) {
    const ssize_t written = ::write(descriptor, content.data() + done, content.size() - done);
    if (written >= 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(unfinished.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(unfinished.c_str());
    refuse_write(file, error);
  }
}

std::string read_whole(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    throw InputError(
        fmt::format("{}: this is a folder; name the file in it that is meant.", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: the file cannot be opened.", file.string()));
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

}  // namespace graintruth::datasets
