// The folder that a run leaves behind: its file names, and how files get there whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace graintruth::datasets {

// Names inside a run folder. They are a promise to users and scripts.
struct RunFolder {
  std::filesystem::path root;

  std::filesystem::path run() const { return root / "run.json"; }
  std::filesystem::path result() const { return root / "result.json"; }
  std::filesystem::path measured() const { return root / "measured.json"; }
  std::filesystem::path tracking() const { return root / "tracking.json"; }
  std::filesystem::path journal() const { return root / "journal.db"; }
  std::filesystem::path journal_csv() const { return root / "journal.csv"; }
  std::filesystem::path report() const { return root / "report.html"; }
  std::filesystem::path report_pdf() const { return root / "report.pdf"; }
  std::filesystem::path progress() const {
    return root / "progress.json";
  }                                                          // while it is under way
  std::filesystem::path table(std::string_view name) const;  // tables/<name>.csv
  // tables/<name>.unfinished.csv: of the run under way, beside the table of an earlier one
  std::filesystem::path unfinished_table(std::string_view name) const;
  std::filesystem::path tracks(std::string_view replicate) const;  // tracks/<replicate>.csv
  // tracks/<replicate>.<name>.csv: what else a film tells; "stagnant": how high the bed stands
  // still, where plates in motion are smeared
  std::filesystem::path film_table(std::string_view replicate, std::string_view name) const;
  std::filesystem::path overlay(
      std::string_view replicate) const;  // tracks/<replicate>.overlay.mp4
  // tracks/<replicate>.<moment>.jpg: a frame with what was found drawn on it
  std::filesystem::path annotated_frame(std::string_view replicate, std::string_view moment) const;
  // A film beside a simulation of it; the list of its stills; the still of a number from 0
  std::filesystem::path side_by_side() const { return root / "side_by_side.mp4"; }
  std::filesystem::path side_by_side_list() const { return root / "side_by_side.json"; }
  std::filesystem::path side_by_side_still(std::size_t number) const;
  std::filesystem::path tracking_of(std::string_view replicate) const;  // tracks/<replicate>.json
};

// Makes the folder (and tables/, tracks/) and proves that it can be written. Throws InputError if
// not.
RunFolder open_run_folder(const std::filesystem::path& root);

// Removes what a process that was killed had begun to write: files called *.unfinished and
// *.unfinished.*. Only for who has the folder for himself.
void remove_unfinished(const RunFolder& folder);

// Makes a folder and those above it. Throws InputError if it cannot be made.
void make_folder(const std::filesystem::path& folder);

// The run is not under way any more: progress.json and its tables go.
void remove_progress(const RunFolder& folder);

// Writes beside the file, flushes to disk, then renames over it. Throws InputError when the disk
// refuses.
void write_whole(const std::filesystem::path& file, std::string_view content);

std::string read_whole(const std::filesystem::path& file);

}  // namespace graintruth::datasets
