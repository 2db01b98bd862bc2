// What a run reads besides: films, its journal, results of other runs.
#include <sqlite3.h>

#include <opencv2/core.hpp>

#include "bench/fuzz/reader.h"
#include "calibrate/journal.h"
#include "calibrate/parameters.h"
#include "tracking/film/video.h"

namespace graintruth::fuzz {

namespace {

using Path = std::filesystem::path;

Reader result() {
  return {.name = "result",
          .extension = ".json",
          .seeds = {R"({"parameters":{"friction_particle_particle":{"value":0.3,"lower":0.1},)"
                    R"("friction_particle_wall":{"value":0.2},"restitution":{"value":0.5}},)"
                    R"("time_step":{"fraction":0.5}})"},
          .read = [](const Path& file) {
            each([&] { calibrate::load_parameters(file, {}); },
                 [&] { calibrate::load_time_step_fraction(file); });
          }};
}

// A row of the journal: what a file holds stands in its parameters up to the first line end, and in
// its channels behind it.
Reader journal() {
  std::string cbor("\x81\xa2\x64name\x61x\x66values\x81\xfb\x3f\xf0\0\0\0\0\0\0", 26);
  return {
      .name = "journal",
      .extension = ".row",
      .seeds = {"{\"restitution\":0.5}\n" + cbor, "{}\n\x80"},
      .read = [](const Path& file) {
        static const Path database = [&] {
          const Path path = file.parent_path() / "journal.db";
          calibrate::Journal(path).add({.fingerprint = "a", .problem = "b", .stage = "c"});
          return path;
        }();
        const std::string content = content_of(file);
        const std::size_t end = std::min(content.find('\n'), content.size());
        const std::string parameters = content.substr(0, end);
        const std::string channels = content.substr(std::min(end + 1, content.size()));
        sqlite3* handle = nullptr;
        sqlite3_open(database.c_str(), &handle);
        sqlite3_exec(handle, "PRAGMA synchronous=OFF;", nullptr, nullptr, nullptr);
        sqlite3_stmt* update = nullptr;
        sqlite3_prepare_v2(
            handle, "UPDATE simulation SET parameters=?, channels=?;", -1, &update, nullptr);
        sqlite3_bind_text(
            update, 1, parameters.data(), static_cast<int>(parameters.size()), SQLITE_TRANSIENT);
        sqlite3_bind_blob(
            update, 2, channels.data(), static_cast<int>(channels.size()), SQLITE_TRANSIENT);
        sqlite3_step(update);
        sqlite3_finalize(update);
        sqlite3_close(handle);
        calibrate::Journal(database).rows();
      }};
}

Reader film() {
  std::vector<std::string> films;
  for (const auto& entry : std::filesystem::directory_iterator(bundled / "micro")) {
    if (entry.path().extension() == ".mp4") films.push_back(content_of(entry.path()));
  }
  return {.name = "film", .extension = ".mp4", .seeds = films, .read = [](const Path& file) {
            tracking::VideoReader reader(file, 50.0);
            cv::Mat frame;
            for (int i = 0; i < 3 && reader.read(frame); ++i) {
            }
            reader.warnings();
          }};
}

}  // namespace

std::vector<Reader> readers() { return {result(), journal(), film()}; }

}  // namespace graintruth::fuzz
