#include "calibrate/journal.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <tuple>

#include "calibrate/observables/channel_archive.h"
#include "datasets/parameters/parameter_archive.h"
#include "datasets/store/archive.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

constexpr const char* schema =
    "CREATE TABLE IF NOT EXISTS simulation ("
    " id INTEGER PRIMARY KEY, fingerprint TEXT NOT NULL UNIQUE, problem TEXT NOT NULL,"
    " stage TEXT NOT NULL, parameters TEXT NOT NULL, time_step_fraction REAL NOT NULL,"
    " seed INTEGER NOT NULL, status TEXT NOT NULL, message TEXT NOT NULL, objective REAL,"
    " agreement_percent REAL, time_step_s REAL NOT NULL, seconds REAL NOT NULL,"
    " channels BLOB NOT NULL);";

constexpr const char* parts_schema =
    "CREATE TABLE IF NOT EXISTS problem_part (name TEXT PRIMARY KEY, hash TEXT NOT NULL);";

constexpr const char* columns =
    "id, fingerprint, problem, stage, parameters, time_step_fraction, seed, status, message,"
    " objective, agreement_percent, time_step_s, seconds, channels";

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

// CBOR: every bit of every number.
std::vector<std::uint8_t> bytes_of(const std::vector<Channel>& channels) {
  return datasets::Json::to_cbor(datasets::to_json(channels));
}

std::vector<Channel> channels_of(const std::vector<std::uint8_t>& bytes) {
  return datasets::from_json<std::vector<Channel>>(datasets::Json::from_cbor(bytes));
}

JournalRow row_of(const Statement& statement) {
  JournalRow row;
  row.id = statement.integer(0);
  row.fingerprint = statement.text(1);
  row.problem = statement.text(2);
  row.stage = statement.text(3);
  row.parameters = datasets::from_json<ParameterSet>(datasets::Json::parse(statement.text(4)));
  row.time_step_fraction = statement.number(5);
  row.seed = static_cast<std::uint64_t>(statement.integer(6));
  row.run.status = status_named(statement.text(7));
  row.run.message = statement.text(8);
  row.objective = statement.number(9);
  row.agreement_percent = statement.number(10);
  row.run.time_step = statement.number(11);
  row.run.seconds = statement.number(12);
  row.run.channels = channels_of(statement.blob<std::uint8_t>(13));
  return row;
}

bool has_column(sqlite3* database, const char* column) {
  Statement statement(database, "SELECT 1 FROM pragma_table_info('simulation') WHERE name = ?;");
  statement.bind(1, std::string(column));
  return statement.step();
}

}  // namespace

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
  if (has_column(database_->handle, "problem") && !has_column(database_->handle, "fingerprint")) {
    throw datasets::InputError(
        fmt::format("{}: These simulations are of an earlier version and cannot be continued; "
                    "choose another folder with --out, or remove the file.",
                    file.string()));
  }
  // A network file system may refuse WAL; the rollback journal is as safe, only slower.
  if (Statement wal(database_->handle, "PRAGMA journal_mode=WAL;");
      !wal.step() || wal.text(0) != "wal") {
    Statement(database_->handle, "PRAGMA journal_mode=DELETE;").step();
  }
  Statement(database_->handle, "PRAGMA synchronous=FULL;").step();
  Statement(database_->handle, schema).step();
  Statement(database_->handle, parts_schema).step();
}

Journal::~Journal() = default;

void Journal::belong_to(const SpecParts& parts) {
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

std::optional<SimulatedRun> Journal::find(const std::string& fingerprint) {
  const std::lock_guard lock(database_->mutex);
  Statement statement(database_->handle,
                      fmt::format("SELECT {} FROM simulation WHERE fingerprint = ?;", columns));
  statement.bind(1, fingerprint);
  if (!statement.step()) return std::nullopt;
  return row_of(statement).run;
}

void Journal::add(const JournalRow& row) {
  const std::lock_guard lock(database_->mutex);
  Statement statement(
      database_->handle,
      "INSERT INTO simulation (fingerprint, problem, stage, parameters, time_step_fraction, seed,"
      " status, message, objective, agreement_percent, time_step_s, seconds, channels)"
      " VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO NOTHING;");
  statement.bind(1, row.fingerprint);
  statement.bind(2, row.problem);
  statement.bind(3, row.stage);
  statement.bind(4, datasets::to_json(row.parameters).dump());
  statement.bind(5, row.time_step_fraction);
  statement.bind(6, static_cast<std::int64_t>(row.seed));
  statement.bind(7, std::string(name_of(row.run.status)));
  statement.bind(8, row.run.message);
  statement.bind(9, row.objective);
  statement.bind(10, row.agreement_percent);
  statement.bind(11, row.run.time_step);
  statement.bind(12, row.run.seconds);
  statement.bind(13, bytes_of(row.run.channels));
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
  ParameterSet all;  // every parameter that any row has
  for (const JournalRow& row : rows) {
    for (const auto& [name, value] : row.parameters) all.set(name, value);
  }
  const auto key = [](const JournalRow& row) {
    std::vector<double> values;
    for (const auto& [name, value] : row.parameters) values.push_back(value);
    return std::tuple(row.problem, std::move(values), row.time_step_fraction, row.seed);
  };
  std::sort(
      rows.begin(), rows.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  std::vector<std::string> names = {"problem", "stage"};
  for (const auto& [name, value] : all) names.push_back(name);
  for (const char* name : {"time_step_fraction",
                           "time_step_s",
                           "seed",
                           "status",
                           "message",
                           "objective",
                           "agreement_percent",
                           "seconds"})
    names.emplace_back(name);
  datasets::Table table(std::move(names));
  for (const JournalRow& row : rows) {
    std::vector<std::string> cells = {row.problem, row.stage};
    for (const auto& [name, value] : all) {
      cells.push_back(row.parameters.has(name) ? datasets::number_text(row.parameters.of(name))
                                               : std::string());
    }
    for (std::string& cell : std::vector<std::string>{datasets::number_text(row.time_step_fraction),
                                                      datasets::number_text(row.run.time_step),
                                                      std::to_string(row.seed),
                                                      std::string(name_of(row.run.status)),
                                                      row.run.message,
                                                      datasets::number_text(row.objective),
                                                      datasets::number_text(row.agreement_percent),
                                                      datasets::number_text(row.run.seconds)})
      cells.push_back(std::move(cell));
    table.add(std::move(cells));
  }
  return table;
}

void write_journal_csv(const std::filesystem::path& file, Journal& journal) {
  datasets::write_csv(file, journal_table(journal));
}

}  // namespace graintruth::calibrate
