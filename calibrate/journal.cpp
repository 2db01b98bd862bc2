#include "calibrate/journal.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <tuple>

#include "datasets/input_error.h"

namespace graintruth::calibrate {

namespace {

constexpr const char* schema =
    "CREATE TABLE IF NOT EXISTS simulation ("
    " id INTEGER PRIMARY KEY, problem TEXT NOT NULL, stage TEXT NOT NULL,"
    " friction_particle_particle REAL NOT NULL, friction_particle_wall REAL NOT NULL,"
    " restitution REAL NOT NULL, time_step_fraction REAL NOT NULL, seed INTEGER NOT NULL,"
    " status TEXT NOT NULL, message TEXT NOT NULL, objective REAL, agreement_percent REAL,"
    " time_step_s REAL NOT NULL, seconds REAL NOT NULL,"
    " particles INTEGER NOT NULL, times BLOB NOT NULL, poses BLOB NOT NULL, bin BLOB,"
    " UNIQUE (problem, friction_particle_particle, friction_particle_wall, restitution,"
    "         time_step_fraction, seed));";

constexpr const char* parts_schema =
    "CREATE TABLE IF NOT EXISTS problem_part (name TEXT PRIMARY KEY, hash TEXT NOT NULL);";

constexpr const char* columns =
    "id, problem, stage, friction_particle_particle, friction_particle_wall, restitution,"
    " time_step_fraction, seed, status, message, objective, agreement_percent, time_step_s, "
    "seconds,"
    " particles, times, poses, bin";

RunStatus status_named(std::string_view name) {
  for (const RunStatus status : {RunStatus::unstable, RunStatus::timed_out}) {
    if (name == name_of(status)) return status;
  }
  return RunStatus::completed;
}

// A prepared statement that is finalised when it goes.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) refuse();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  void bind(int at, double value) { sqlite3_bind_double(statement_, at, value); }
  void bind(int at, std::int64_t value) { sqlite3_bind_int64(statement_, at, value); }
  void bind(int at, const std::string& value) {
    sqlite3_bind_text(
        statement_, at, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }
  template <typename Element>
  void bind(int at, const std::vector<Element>& values) {
    // Without an address SQLite would take an empty blob for none.
    if (values.empty()) {
      sqlite3_bind_zeroblob(statement_, at, 0);
      return;
    }
    sqlite3_bind_blob(statement_,
                      at,
                      values.data(),
                      static_cast<int>(values.size() * sizeof(Element)),
                      SQLITE_TRANSIENT);
  }

  // True while there is a row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) refuse();
    return code == SQLITE_ROW;
  }

  // NaN where there is none.
  double number(int at) const {
    if (sqlite3_column_type(statement_, at) == SQLITE_NULL)
      return std::numeric_limits<double>::quiet_NaN();
    return sqlite3_column_double(statement_, at);
  }
  std::int64_t integer(int at) const { return sqlite3_column_int64(statement_, at); }
  std::string text(int at) const {
    return {reinterpret_cast<const char*>(sqlite3_column_text(statement_, at)),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_, at))};
  }
  template <typename Element>
  std::vector<Element> blob(int at) const {
    std::vector<Element> values(static_cast<std::size_t>(sqlite3_column_bytes(statement_, at)) /
                                sizeof(Element));
    if (!values.empty()) {
      std::memcpy(
          values.data(), sqlite3_column_blob(statement_, at), values.size() * sizeof(Element));
    }
    return values;
  }

 private:
  [[noreturn]] void refuse() const {
    const int code = sqlite3_errcode(database_);
    throw datasets::InputError(
        fmt::format("{}: the journal cannot be used ({}){}.",
                    sqlite3_db_filename(database_, "main"),
                    sqlite3_errmsg(database_),
                    code == SQLITE_CORRUPT || code == SQLITE_NOTADB
                        ? "; remove the file, and its simulations are run anew"
                        : ""));
  }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

// What was measured of a bin as plain numbers, and back: counts before what they count.
std::vector<double> numbers_of(const BinMeasurement& bin) {
  const Discharge& discharge = bin.discharge;
  if (discharge.particles == 0) return {};
  std::vector<double> numbers = {static_cast<double>(discharge.particles),
                                 static_cast<double>(discharge.over_orifice),
                                 discharge.from,
                                 discharge.to,
                                 static_cast<double>(discharge.times.size())};
  numbers.insert(numbers.end(), discharge.times.begin(), discharge.times.end());
  numbers.push_back(static_cast<double>(bin.at_rest.surface.size()));
  numbers.insert(numbers.end(), bin.at_rest.surface.begin(), bin.at_rest.surface.end());
  for (const double value : {bin.at_rest.area,
                             bin.at_rest.solid_fraction,
                             bin.at_rest.areal_density,
                             bin.flowing_density,
                             bin.profile.height,
                             bin.profile.areal_density,
                             bin.profile.flux,
                             static_cast<double>(bin.profile.samples.size())})
    numbers.push_back(value);
  for (const VelocitySample& sample : bin.profile.samples) {
    for (const double value : {sample.x, sample.velocity, sample.standard_uncertainty})
      numbers.push_back(value);
  }
  numbers.push_back(static_cast<double>(bin.stagnant_heights.size()));
  numbers.insert(numbers.end(), bin.stagnant_heights.begin(), bin.stagnant_heights.end());
  return numbers;
}

BinMeasurement bin_of(const std::vector<double>& numbers) {
  BinMeasurement bin;
  if (numbers.empty()) return bin;
  // A row that another hand has cut short reads as zeros.
  std::size_t next = 0;
  const auto number = [&] { return next < numbers.size() ? numbers[next++] : 0.0; };
  const auto count = [&] {
    return static_cast<std::size_t>(std::clamp(number(), 0.0, static_cast<double>(numbers.size())));
  };
  bin.discharge.particles = static_cast<int>(number());
  bin.discharge.over_orifice = static_cast<int>(number());
  bin.discharge.from = number();
  bin.discharge.to = number();
  bin.discharge.times.resize(count());
  for (double& time : bin.discharge.times) time = number();
  bin.at_rest.surface.resize(count());
  for (double& height : bin.at_rest.surface) height = number();
  for (double* value : {&bin.at_rest.area,
                        &bin.at_rest.solid_fraction,
                        &bin.at_rest.areal_density,
                        &bin.flowing_density,
                        &bin.profile.height,
                        &bin.profile.areal_density,
                        &bin.profile.flux})
    *value = number();
  bin.profile.samples.resize(count());
  for (VelocitySample& sample : bin.profile.samples) {
    sample.x = number();
    sample.velocity = number();
    sample.standard_uncertainty = number();
  }
  bin.stagnant_heights.resize(count());
  for (double& height : bin.stagnant_heights) height = number();
  return bin;
}

JournalRow row_of(const Statement& statement) {
  JournalRow row;
  row.id = statement.integer(0);
  row.problem = statement.text(1);
  row.stage = statement.text(2);
  row.request = {{statement.number(3), statement.number(4), statement.number(5)},
                 statement.number(6),
                 static_cast<std::uint64_t>(statement.integer(7))};
  row.run.status = status_named(statement.text(8));
  row.run.message = statement.text(9);
  row.objective = statement.number(10);
  row.agreement_percent = statement.number(11);
  row.run.time_step = statement.number(12);
  row.run.seconds = statement.number(13);
  row.run.trajectories.particles = static_cast<int>(statement.integer(14));
  row.run.trajectories.time = statement.blob<double>(15);
  row.run.trajectories.poses = statement.blob<datasets::Pose>(16);
  row.run.bin = bin_of(statement.blob<double>(17));
  return row;
}

}  // namespace

std::string_view name_of(RunStatus status) {
  switch (status) {
    case RunStatus::completed:
      return "completed";
    case RunStatus::unstable:
      return "unstable";
    case RunStatus::timed_out:
      return "timed_out";
  }
  return "";
}

struct Journal::Database {
  sqlite3* handle = nullptr;
  std::mutex mutex;
  std::filesystem::path file;
  ~Database() { sqlite3_close(handle); }
};

Journal::Journal(const std::filesystem::path& file) : database_(std::make_unique<Database>()) {
  if (sqlite3_open(file.c_str(), &database_->handle) != SQLITE_OK) {
    throw datasets::InputError(fmt::format("{}: the journal cannot be opened ({}).",
                                           file.string(),
                                           sqlite3_errmsg(database_->handle)));
  }
  database_->file = file;
  sqlite3_busy_timeout(database_->handle, 10000);
  // A network file system may refuse WAL; the rollback journal is as safe, only slower.
  if (Statement wal(database_->handle, "PRAGMA journal_mode=WAL;");
      !wal.step() || wal.text(0) != "wal") {
    Statement(database_->handle, "PRAGMA journal_mode=DELETE;").step();
  }
  Statement(database_->handle, "PRAGMA synchronous=FULL;").step();
  Statement(database_->handle, schema).step();
  Statement(database_->handle, parts_schema).step();
  // Journals of before bins were simulated lack their column.
  Statement has_bin(database_->handle,
                    "SELECT 1 FROM pragma_table_info('simulation') WHERE name = 'bin';");
  if (!has_bin.step())
    Statement(database_->handle, "ALTER TABLE simulation ADD COLUMN bin BLOB;").step();
}

Journal::~Journal() = default;

void Journal::belong_to(const ProblemParts& parts) {
  const std::lock_guard lock(database_->mutex);
  std::vector<std::string> changed;
  for (const auto& [name, hash] : parts) {
    Statement known(database_->handle, "SELECT hash FROM problem_part WHERE name = ?;");
    known.bind(1, name);
    if (known.step() && known.text(0) != hash) changed.push_back(name);
  }
  if (!changed.empty()) {
    throw datasets::InputError(
        fmt::format("{}: the simulations in it were made for another problem ({} changed since); "
                    "choose another folder with --out, or remove the file.",
                    database_->file.string(),
                    fmt::join(changed, ", ")));
  }
  for (const auto& [name, hash] : parts) {
    Statement insert(database_->handle, "INSERT OR IGNORE INTO problem_part VALUES (?,?);");
    insert.bind(1, name);
    insert.bind(2, hash);
    insert.step();
  }
}

std::optional<SimulatedRun> Journal::find(const std::string& problem,
                                          const SimulationRequest& request) {
  const std::lock_guard lock(database_->mutex);
  Statement statement(
      database_->handle,
      fmt::format("SELECT {} FROM simulation WHERE problem = ? AND friction_particle_particle = ?"
                  " AND friction_particle_wall = ? AND restitution = ? AND time_step_fraction = ?"
                  " AND seed = ?;",
                  columns));
  statement.bind(1, problem);
  statement.bind(2, request.parameters.friction_particle_particle);
  statement.bind(3, request.parameters.friction_particle_wall);
  statement.bind(4, request.parameters.restitution);
  statement.bind(5, request.time_step_fraction);
  statement.bind(6, static_cast<std::int64_t>(request.seed));
  if (!statement.step()) return std::nullopt;
  return row_of(statement).run;
}

void Journal::add(const JournalRow& row) {
  const std::lock_guard lock(database_->mutex);
  Statement statement(
      database_->handle,
      "INSERT INTO simulation (problem, stage, friction_particle_particle,"
      " friction_particle_wall, restitution, time_step_fraction, seed, status, message, objective,"
      " agreement_percent, time_step_s, seconds, particles, times, poses, bin)"
      " VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO NOTHING;");
  statement.bind(1, row.problem);
  statement.bind(2, row.stage);
  statement.bind(3, row.request.parameters.friction_particle_particle);
  statement.bind(4, row.request.parameters.friction_particle_wall);
  statement.bind(5, row.request.parameters.restitution);
  statement.bind(6, row.request.time_step_fraction);
  statement.bind(7, static_cast<std::int64_t>(row.request.seed));
  statement.bind(8, std::string(name_of(row.run.status)));
  statement.bind(9, row.run.message);
  statement.bind(10, row.objective);
  statement.bind(11, row.agreement_percent);
  statement.bind(12, row.run.time_step);
  statement.bind(13, row.run.seconds);
  statement.bind(14, static_cast<std::int64_t>(row.run.trajectories.particles));
  statement.bind(15, row.run.trajectories.time);
  statement.bind(16, row.run.trajectories.poses);
  statement.bind(17, numbers_of(row.run.bin));
  statement.step();
}

std::vector<JournalRow> Journal::rows() {
  const std::lock_guard lock(database_->mutex);
  Statement statement(database_->handle,
                      fmt::format("SELECT {} FROM simulation ORDER BY id;", columns));
  std::vector<JournalRow> rows;
  while (statement.step()) rows.push_back(row_of(statement));
  return rows;
}

void Journal::drop(std::span<const std::int64_t> ids) {
  const std::lock_guard lock(database_->mutex);
  Statement(database_->handle, "BEGIN IMMEDIATE;").step();
  try {
    for (const std::int64_t id : ids) {
      Statement statement(database_->handle, "DELETE FROM simulation WHERE id = ?;");
      statement.bind(1, id);
      statement.step();
    }
    Statement(database_->handle, "COMMIT;").step();
  } catch (...) {
    sqlite3_exec(database_->handle, "ROLLBACK;", nullptr, nullptr, nullptr);
    throw;
  }
}

std::vector<std::string> Journal::problems() {
  const std::lock_guard lock(database_->mutex);
  Statement statement(database_->handle,
                      "SELECT DISTINCT problem FROM simulation ORDER BY problem;");
  std::vector<std::string> all;
  while (statement.step()) all.push_back(statement.text(0));
  return all;
}

datasets::Table journal_table(Journal& journal) {
  std::vector<JournalRow> rows = journal.rows();
  const auto key = [](const JournalRow& row) {
    const SimulationRequest& request = row.request;
    return std::tuple(row.problem,
                      request.parameters.friction_particle_particle,
                      request.parameters.friction_particle_wall,
                      request.parameters.restitution,
                      request.time_step_fraction,
                      request.seed);
  };
  std::sort(
      rows.begin(), rows.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  datasets::Table table({"problem",
                         "stage",
                         "friction_particle_particle",
                         "friction_particle_wall",
                         "restitution",
                         "time_step_fraction",
                         "time_step_s",
                         "seed",
                         "status",
                         "message",
                         "objective",
                         "agreement_percent",
                         "seconds"});
  for (const JournalRow& row : rows) {
    table.add({row.problem,
               row.stage,
               datasets::number_text(row.request.parameters.friction_particle_particle),
               datasets::number_text(row.request.parameters.friction_particle_wall),
               datasets::number_text(row.request.parameters.restitution),
               datasets::number_text(row.request.time_step_fraction),
               datasets::number_text(row.run.time_step),
               std::to_string(row.request.seed),
               std::string(name_of(row.run.status)),
               row.run.message,
               datasets::number_text(row.objective),
               datasets::number_text(row.agreement_percent),
               datasets::number_text(row.run.seconds)});
  }
  return table;
}

void write_journal_csv(const std::filesystem::path& file, Journal& journal) {
  datasets::write_csv(file, journal_table(journal));
}

}  // namespace graintruth::calibrate
