#include "calibrate/journal.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <tuple>

#include "calibrate/observables/channel_archive.h"
#include "datasets/parameters/parameter_archive.h"
#include "datasets/store/archive.h"
#include "datasets/store/fingerprint.h"
#include "datasets/store/input_error.h"

namespace graintruth::calibrate {

namespace {

// Goes up whenever the file is laid out in another way; 0 had no checksums.
constexpr int layout_version = 2;
constexpr int application = 0x47725472;  // "GrTr", which tells the file from other databases

constexpr const char* schema =
    "CREATE TABLE IF NOT EXISTS simulation ("
    " id INTEGER PRIMARY KEY, fingerprint TEXT NOT NULL UNIQUE, problem TEXT NOT NULL,"
    " stage TEXT NOT NULL, parameters TEXT NOT NULL, time_step_fraction REAL NOT NULL,"
    " seed INTEGER NOT NULL, status TEXT NOT NULL, message TEXT NOT NULL, objective REAL,"
    " agreement_percent REAL, time_step_s REAL NOT NULL, seconds REAL NOT NULL,"
    " channels BLOB NOT NULL, checksum TEXT NOT NULL DEFAULT '');";

constexpr const char* parts_schema =
    "CREATE TABLE IF NOT EXISTS problem_part (name TEXT PRIMARY KEY, hash TEXT NOT NULL);";

// In the order in which rows are read and written, with what each of them must hold.
struct Column {
  const char* name;
  int type;
  bool may_be_null = false;
};
constexpr std::array columns = {Column{"id", SQLITE_INTEGER},
                                Column{"fingerprint", SQLITE_TEXT},
                                Column{"problem", SQLITE_TEXT},
                                Column{"stage", SQLITE_TEXT},
                                Column{"parameters", SQLITE_TEXT},
                                Column{"time_step_fraction", SQLITE_FLOAT},
                                Column{"seed", SQLITE_INTEGER},
                                Column{"status", SQLITE_TEXT},
                                Column{"message", SQLITE_TEXT},
                                Column{"objective", SQLITE_FLOAT, true},
                                Column{"agreement_percent", SQLITE_FLOAT, true},
                                Column{"time_step_s", SQLITE_FLOAT},
                                Column{"seconds", SQLITE_FLOAT},
                                Column{"channels", SQLITE_BLOB}};

std::string column_list() {
  std::vector<std::string_view> names;
  for (const Column& column : columns) names.emplace_back(column.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string_view words_of(int type) {
  switch (type) {
    case SQLITE_TEXT:
      return "a text";
    case SQLITE_BLOB:
      return "a block of bytes";
    case SQLITE_NULL:
      return "nothing";
    default:
      return "a number";
  }
}

std::optional<RunStatus> status_named(std::string_view name) {
  for (const RunStatus status : {RunStatus::completed, RunStatus::unstable, RunStatus::timed_out}) {
    if (name == name_of(status)) return status;
  }
  return std::nullopt;
}

// What is wrong with a file, and what to do.
std::string advice(int code) {
  switch (code & 0xff) {  // without the extension
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "; remove the file, and its simulations are run anew";
    case SQLITE_FULL:
    case SQLITE_IOERR:
      return "; make room on the disk and run the same command again: what had ended is kept";
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return "; make file and folder writable, or choose another folder with --out";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "; another process is at work on it: wait for its end";
    default:
      return "";
  }
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
  void bind(int at, const std::vector<std::uint8_t>& bytes) {
    // Without an address SQLite would take an empty blob for none.
    if (bytes.empty()) {
      sqlite3_bind_zeroblob(statement_, at, 0);
      return;
    }
    sqlite3_bind_blob(
        statement_, at, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
  }

  // True while there is a row.
  bool step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) refuse();
    return code == SQLITE_ROW;
  }

  int type(int at) const { return sqlite3_column_type(statement_, at); }
  // NaN where there is none.
  double number(int at) const {
    if (type(at) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
    return sqlite3_column_double(statement_, at);
  }
  std::int64_t integer(int at) const { return sqlite3_column_int64(statement_, at); }
  std::string text(int at) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, at));
    if (text == nullptr) return {};
    return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, at))};
  }
  std::vector<std::uint8_t> blob(int at) const {
    const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_, at));
    if (bytes == nullptr) return {};
    return {bytes, bytes + sqlite3_column_bytes(statement_, at)};
  }

 private:
  [[noreturn]] void refuse() const {
    throw datasets::InputError(fmt::format("{}: the journal cannot be used ({}){}.",
                                           sqlite3_db_filename(database_, "main"),
                                           sqlite3_errmsg(database_),
                                           advice(sqlite3_errcode(database_))));
  }

  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

// CBOR: every bit of every number.
std::vector<std::uint8_t> bytes_of(const std::vector<Channel>& channels) {
  return datasets::Json::to_cbor(datasets::to_json(channels));
}

// A row as the file has it.
struct StoredRow {
  std::int64_t id = 0;
  std::string fingerprint, problem, stage, parameters;
  double time_step_fraction = 0.0;
  std::int64_t seed = 0;
  std::string status, message;
  double objective = 0.0, agreement_percent = 0.0, time_step = 0.0, seconds = 0.0;
  std::vector<std::uint8_t> channels;
  std::string checksum;
  std::string complaint;  // of what its columns hold; empty where nothing is wrong

  // Of everything but its number, which changes from file to file.
  std::string content_hash() const;
};

std::string StoredRow::content_hash() const {
  std::string all;
  const auto add_text = [&](const std::string& text) {
    all += fmt::format("{}:", text.size());
    all += text;
  };
  // SQLite keeps neither the sign of nought nor which NaN it was
  const auto add_number = [&](double value) {
    if (value == 0.0) value = 0.0;
    if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
    all.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const std::string* text : {&fingerprint, &problem, &stage, &parameters, &status, &message})
    add_text(*text);
  for (const double number : {time_step_fraction, objective, agreement_percent, time_step, seconds})
    add_number(number);
  all += fmt::format("{}:", seed);
  all.append(channels.begin(), channels.end());
  return datasets::content_hash(all);
}

StoredRow stored(const JournalRow& row) {
  StoredRow made{.fingerprint = row.fingerprint,
                 .problem = row.problem,
                 .stage = row.stage,
                 .parameters = datasets::to_json(row.parameters).dump(),
                 .time_step_fraction = row.time_step_fraction,
                 .seed = static_cast<std::int64_t>(row.seed),
                 .status = std::string(name_of(row.run.status)),
                 .message = row.run.message,
                 .objective = row.objective,
                 .agreement_percent = row.agreement_percent,
                 .time_step = row.run.time_step,
                 .seconds = row.run.seconds,
                 .channels = bytes_of(row.run.channels)};
  made.checksum = made.content_hash();
  return made;
}

// Of a statement that selects column_list(), and the checksum after it.
StoredRow stored(const Statement& statement) {
  StoredRow row;
  row.id = statement.integer(0);
  for (std::size_t i = 1; i < columns.size(); ++i) {
    const Column& column = columns[i];
    const int type = statement.type(static_cast<int>(i));
    if (type == column.type || (type == SQLITE_NULL && column.may_be_null)) continue;
    row.complaint = fmt::format(
        "its {} holds {}, but {} is needed", column.name, words_of(type), words_of(column.type));
    return row;
  }
  int at = 1;
  row.fingerprint = statement.text(at++);
  row.problem = statement.text(at++);
  row.stage = statement.text(at++);
  row.parameters = statement.text(at++);
  row.time_step_fraction = statement.number(at++);
  row.seed = statement.integer(at++);
  row.status = statement.text(at++);
  row.message = statement.text(at++);
  row.objective = statement.number(at++);
  row.agreement_percent = statement.number(at++);
  row.time_step = statement.number(at++);
  row.seconds = statement.number(at++);
  row.channels = statement.blob(at++);
  row.checksum = statement.text(at);
  return row;
}

// Its columns understood. What cannot be throws std::invalid_argument, whose text goes on after
// "its".
JournalRow understood(const StoredRow& stored) {
  JournalRow row{.id = stored.id,
                 .fingerprint = stored.fingerprint,
                 .problem = stored.problem,
                 .stage = stored.stage,
                 .time_step_fraction = stored.time_step_fraction,
                 .seed = static_cast<std::uint64_t>(stored.seed),
                 .objective = stored.objective,
                 .agreement_percent = stored.agreement_percent};
  const auto status = status_named(stored.status);
  if (!status) {
    throw std::invalid_argument(
        fmt::format("status is '{}', with which no simulation ends", stored.status));
  }
  row.run.status = *status;
  row.run.message = stored.message;
  row.run.time_step = stored.time_step;
  row.run.seconds = stored.seconds;
  for (const auto& [name, value] : {std::pair("time_step_fraction", stored.time_step_fraction),
                                    std::pair("time_step_s", stored.time_step),
                                    std::pair("seconds", stored.seconds)}) {
    if (!std::isfinite(value) || value < 0.0)
      throw std::invalid_argument(fmt::format("{} is {}, which cannot be", name, value));
  }
  try {
    row.parameters = datasets::from_json<ParameterSet>(datasets::Json::parse(stored.parameters));
  } catch (const datasets::Json::exception&) {
    throw std::invalid_argument("parameters are cut off or no JSON");
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("parameters cannot be read: {}", error.what()));
  }
  try {
    row.run.channels =
        datasets::from_json<std::vector<Channel>>(datasets::Json::from_cbor(stored.channels));
  } catch (const datasets::Json::exception&) {
    throw std::invalid_argument("channels are cut off or no CBOR");
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("channels cannot be read: {}", error.what()));
  }
  if (*status != RunStatus::completed && !row.run.channels.empty()) {
    throw std::invalid_argument(fmt::format("status is '{}', but it has results", stored.status));
  }
  return row;
}

// Either the row, or what is wrong with it.
struct CheckedRow {
  JournalRow row;
  std::string complaint;
};

CheckedRow checked(const StoredRow& stored, bool has_checksum) {
  CheckedRow checked{.complaint = stored.complaint};
  checked.row.id = stored.id;
  checked.row.fingerprint = stored.fingerprint;
  if (!checked.complaint.empty()) return checked;
  try {
    checked.row = understood(stored);
  } catch (const std::invalid_argument& error) {
    checked.complaint = fmt::format("its {}", error.what());
    return checked;
  }
  if (has_checksum && stored.checksum != stored.content_hash())
    checked.complaint = "it was changed after it was written, as its checksum tells";
  return checked;
}

bool has_table(sqlite3* database, const char* table) {
  Statement statement(database, "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?;");
  statement.bind(1, std::string(table));
  return statement.step();
}

bool has_column(sqlite3* database, const char* column) {
  Statement statement(database, "SELECT 1 FROM pragma_table_info('simulation') WHERE name = ?;");
  statement.bind(1, std::string(column));
  return statement.step();
}

std::int64_t first_number(sqlite3* database, const std::string& sql) {
  Statement statement(database, sql);
  return statement.step() ? statement.integer(0) : 0;
}

// Everything between the two, or nothing of it.
class Transaction {
 public:
  explicit Transaction(sqlite3* database) : database_(database) {
    Statement(database_, "BEGIN IMMEDIATE;").step();
  }
  ~Transaction() {
    if (!is_committed_) sqlite3_exec(database_, "ROLLBACK;", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    Statement(database_, "COMMIT;").step();
    is_committed_ = true;
  }

 private:
  sqlite3* database_;
  bool is_committed_ = false;
};

// As SQLite takes the name of a file with options behind it.
std::string as_uri(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : file.string()) {
    if (c == '?' || c == '#' || c == '%') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri;
}

}  // namespace

struct Journal::Database {
  sqlite3* handle = nullptr;
  std::mutex mutex;
  std::filesystem::path file;
  bool has_checksums = true;
  ~Database() { sqlite3_close(handle); }

  Statement select(const std::string& condition) const {
    return {handle,
            fmt::format("SELECT {}, {} FROM simulation {};",
                        column_list(),
                        has_checksums ? "checksum" : "''",
                        condition)};
  }
  CheckedRow read(const Statement& statement) const {
    return checked(stored(statement), has_checksums);
  }
};

Journal::Journal(const std::filesystem::path& file, Use use)
    : database_(std::make_unique<Database>()) {
  database_->file = file;
  if (use == Use::reading) {
    open_for_reading();
    require_known_kind();
    database_->has_checksums = has_column(database_->handle, "checksum");
    return;
  }
  std::error_code error;
  if (std::filesystem::exists(file, error) && std::filesystem::file_size(file, error) == 0) {
    notices_.push_back(
        fmt::format("{}: the journal is empty, so every simulation is run anew.", file.string()));
  }
  if (sqlite3_open(file.c_str(), &database_->handle) != SQLITE_OK) {
    throw datasets::InputError(fmt::format("{}: the journal cannot be opened ({}){}.",
                                           file.string(),
                                           sqlite3_errmsg(database_->handle),
                                           advice(sqlite3_errcode(database_->handle))));
  }
  sqlite3_busy_timeout(database_->handle, 10000);
  require_known_kind();
  prepare_for_writing();
}

Journal::~Journal() = default;

// A journal in a folder that cannot be written has no room for SQLite's own files: it is then read
// as a file that nobody changes.
void Journal::open_for_reading() {
  const std::filesystem::path& file = database_->file;
  const auto open = [&](const char* option) {
    return sqlite3_open_v2((as_uri(file) + option).c_str(),
                           &database_->handle,
                           SQLITE_OPEN_READONLY | SQLITE_OPEN_URI,
                           nullptr) == SQLITE_OK;
  };
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  const bool is_fixed = ::access(folder.c_str(), W_OK) != 0;
  std::error_code error;
  const auto waiting = std::filesystem::file_size(file.string() + "-wal", error);
  if (is_fixed && !error && waiting > 0) {
    throw datasets::InputError(
        fmt::format("{}: its last simulations still stand in {}-wal, which can only be read where "
                    "the folder can be written; copy the folder, and read the copy.",
                    file.string(),
                    file.filename().string()));
  }
  if (open(is_fixed ? "?immutable=1" : "")) {
    sqlite3_busy_timeout(database_->handle, 10000);
    return;
  }
  throw datasets::InputError(fmt::format(
      "{}: the journal cannot be opened ({}).", file.string(), sqlite3_errmsg(database_->handle)));
}

// Refuses what is of another program or version.
void Journal::require_known_kind() {
  sqlite3* const handle = database_->handle;
  const std::string file = database_->file.string();
  const std::int64_t version = first_number(handle, "PRAGMA user_version;");
  if (const std::int64_t owner = first_number(handle, "PRAGMA application_id;");
      owner != 0 && owner != application) {
    throw datasets::InputError(fmt::format(
        "{}: this is a database of another program; choose another folder with --out.", file));
  }
  if (version > layout_version) {
    throw datasets::InputError(
        fmt::format("{}: the journal was made by a newer program (layout {}, this program knows "
                    "{}); use that program, or choose another folder with --out.",
                    file,
                    version,
                    layout_version));
  }
  if (!has_table(handle, "simulation")) {
    if (first_number(handle, "SELECT COUNT(*) FROM sqlite_master WHERE name <> 'problem_part';") ==
        0)
      return;
    throw datasets::InputError(fmt::format(
        "{}: this is a database of another program; choose another folder with --out.", file));
  }
  if (has_column(handle, "problem") && !has_column(handle, "fingerprint")) {
    throw datasets::InputError(
        fmt::format("{}: These simulations are of an earlier version and cannot be continued; "
                    "choose another folder with --out, or remove the file.",
                    file));
  }
  for (const Column& column : columns) {
    if (has_column(handle, column.name)) continue;
    throw datasets::InputError(
        fmt::format("{}: the journal has no column '{}', so that it is of another program or "
                    "version; choose another folder with --out, or remove the file.",
                    file,
                    column.name));
  }
}

void Journal::prepare_for_writing() {
  sqlite3* const handle = database_->handle;
  if (sqlite3_db_readonly(handle, "main") == 1) {
    throw datasets::InputError(fmt::format(
        "{}: the journal cannot be written{}.", database_->file.string(), advice(SQLITE_READONLY)));
  }
  // A network file system may refuse WAL; the rollback journal is as safe, only slower.
  if (Statement wal(handle, "PRAGMA journal_mode=WAL;"); !wal.step() || wal.text(0) != "wal") {
    Statement(handle, "PRAGMA journal_mode=DELETE;").step();
  }
  Statement(handle, "PRAGMA synchronous=FULL;").step();
  if (first_number(handle, "PRAGMA user_version;") == layout_version &&
      has_table(handle, "simulation") && has_table(handle, "problem_part"))
    return;
  Transaction whole(handle);
  Statement(handle, schema).step();
  Statement(handle, parts_schema).step();
  if (!has_column(handle, "checksum")) give_checksums();
  Statement(handle, fmt::format("PRAGMA application_id = {};", application)).step();
  Statement(handle, fmt::format("PRAGMA user_version = {};", layout_version)).step();
  whole.commit();
}

// To the rows of an earlier version. Those that cannot be read get none, and so stay refused.
void Journal::give_checksums() {
  sqlite3* const handle = database_->handle;
  Statement(handle, "ALTER TABLE simulation ADD COLUMN checksum TEXT NOT NULL DEFAULT '';").step();
  std::vector<std::pair<std::int64_t, std::string>> given;
  for (Statement statement = database_->select(""); statement.step();) {
    const StoredRow row = stored(statement);
    if (checked(row, false).complaint.empty()) given.emplace_back(row.id, row.content_hash());
  }
  for (const auto& [id, checksum] : given) {
    Statement statement(handle, "UPDATE simulation SET checksum = ? WHERE id = ?;");
    statement.bind(1, checksum);
    statement.bind(2, id);
    statement.step();
  }
  notices_.push_back(
      fmt::format("{}: the journal is of an earlier version without checksums; its {} simulations "
                  "can be read and now have them.",
                  database_->file.string(),
                  given.size()));
}

void Journal::refuse_row(std::int64_t id, const std::string& complaint) const {
  const std::filesystem::path folder = database_->file.parent_path();
  throw datasets::InputError(
      fmt::format("{}: row {} is damaged: {}; 'graintruth journal drop {} --damaged' removes it "
                  "and all others like it, so that they are simulated again.",
                  database_->file.string(),
                  id,
                  complaint,
                  folder.empty() ? "." : folder.string()));
}

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

SpecParts Journal::parts() {
  const std::lock_guard lock(database_->mutex);
  SpecParts parts;
  if (!has_table(database_->handle, "problem_part")) return parts;
  Statement statement(database_->handle, "SELECT name, hash FROM problem_part ORDER BY name;");
  while (statement.step()) parts.emplace_back(statement.text(0), statement.text(1));
  return parts;
}

void Journal::require_sound() {
  const std::lock_guard lock(database_->mutex);
  if (Statement file(database_->handle, "PRAGMA integrity_check(1);");
      file.step() && file.text(0) != "ok") {
    throw datasets::InputError(fmt::format("{}: the journal is damaged as a file ({}){}.",
                                           database_->file.string(),
                                           file.text(0),
                                           advice(SQLITE_CORRUPT)));
  }
  if (!has_table(database_->handle, "simulation")) return;
  for (Statement statement = database_->select("ORDER BY id"); statement.step();) {
    const CheckedRow read = database_->read(statement);
    if (!read.complaint.empty()) refuse_row(read.row.id, read.complaint);
  }
  Statement twice(database_->handle,
                  "SELECT MIN(id), MAX(id) FROM simulation GROUP BY fingerprint"
                  " HAVING COUNT(*) > 1;");
  if (twice.step()) {
    refuse_row(twice.integer(1), fmt::format("row {} is of the same simulation", twice.integer(0)));
  }
}

std::vector<std::int64_t> Journal::damaged() {
  const std::lock_guard lock(database_->mutex);
  std::vector<std::int64_t> found;
  for (Statement statement = database_->select("ORDER BY id"); statement.step();) {
    const CheckedRow read = database_->read(statement);
    if (!read.complaint.empty()) found.push_back(read.row.id);
  }
  Statement twice(database_->handle,
                  "SELECT id FROM simulation WHERE fingerprint IN (SELECT fingerprint FROM"
                  " simulation GROUP BY fingerprint HAVING COUNT(*) > 1);");
  while (twice.step()) found.push_back(twice.integer(0));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::optional<JournalRow> Journal::row_of(const std::string& fingerprint) {
  const std::lock_guard lock(database_->mutex);
  Statement statement = database_->select("WHERE fingerprint = ?");
  statement.bind(1, fingerprint);
  if (!statement.step()) return std::nullopt;
  CheckedRow read = database_->read(statement);
  if (!read.complaint.empty()) refuse_row(read.row.id, read.complaint);
  return std::move(read.row);
}

std::optional<SimulatedRun> Journal::find(const std::string& fingerprint) {
  std::optional<JournalRow> row = row_of(fingerprint);
  if (!row || row->run.status == RunStatus::timed_out) return std::nullopt;
  return std::move(row->run);
}

void Journal::refuse(const std::string& fingerprint, const std::string& complaint) {
  const std::optional<JournalRow> row = row_of(fingerprint);
  refuse_row(row ? row->id : 0, complaint);
}

void Journal::add(const JournalRow& row) {
  const std::lock_guard lock(database_->mutex);
  const StoredRow made = stored(row);
  Transaction whole(database_->handle);
  Statement before(database_->handle,
                   "DELETE FROM simulation WHERE fingerprint = ? AND status = ?;");
  before.bind(1, made.fingerprint);
  before.bind(2, std::string(name_of(RunStatus::timed_out)));
  before.step();
  Statement statement(
      database_->handle,
      "INSERT INTO simulation (fingerprint, problem, stage, parameters, time_step_fraction, seed,"
      " status, message, objective, agreement_percent, time_step_s, seconds, channels, checksum)"
      " VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO NOTHING;");
  int at = 1;
  statement.bind(at++, made.fingerprint);
  statement.bind(at++, made.problem);
  statement.bind(at++, made.stage);
  statement.bind(at++, made.parameters);
  statement.bind(at++, made.time_step_fraction);
  statement.bind(at++, made.seed);
  statement.bind(at++, made.status);
  statement.bind(at++, made.message);
  statement.bind(at++, made.objective);
  statement.bind(at++, made.agreement_percent);
  statement.bind(at++, made.time_step);
  statement.bind(at++, made.seconds);
  statement.bind(at++, made.channels);
  statement.bind(at, made.checksum);
  statement.step();
  whole.commit();
}

std::vector<JournalRow> Journal::rows() {
  const std::lock_guard lock(database_->mutex);
  std::vector<JournalRow> rows;
  if (!has_table(database_->handle, "simulation")) return rows;
  for (Statement statement = database_->select("ORDER BY id"); statement.step();) {
    CheckedRow read = database_->read(statement);
    if (!read.complaint.empty()) refuse_row(read.row.id, read.complaint);
    rows.push_back(std::move(read.row));
  }
  return rows;
}

std::vector<std::int64_t> Journal::ids(const std::string& condition, const std::string& value) {
  const std::lock_guard lock(database_->mutex);
  Statement statement(database_->handle,
                      fmt::format("SELECT id FROM simulation WHERE {} ORDER BY id;", condition));
  statement.bind(1, value);
  std::vector<std::int64_t> found;
  while (statement.step()) found.push_back(statement.integer(0));
  return found;
}

std::vector<std::int64_t> Journal::failed() {
  return ids("status <> ?", std::string(name_of(RunStatus::completed)));
}

std::vector<std::int64_t> Journal::of_problem(const std::string& problem) {
  return ids("problem = ?", problem);
}

std::vector<std::int64_t> Journal::all() { return ids("? = ''", ""); }

void Journal::drop(std::span<const std::int64_t> ids) {
  const std::lock_guard lock(database_->mutex);
  Transaction whole(database_->handle);
  for (const std::int64_t id : ids) {
    Statement statement(database_->handle, "DELETE FROM simulation WHERE id = ?;");
    statement.bind(1, id);
    statement.step();
  }
  whole.commit();
}

bool is_same_result(const JournalRow& a, const JournalRow& b) {
  return a.run.status == b.run.status && a.run.message == b.run.message &&
         bytes_of(a.run.channels) == bytes_of(b.run.channels);
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
