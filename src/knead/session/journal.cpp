#include "knead/session/journal.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cerrno>
#include <ctime>
#include <fstream>
#include <system_error>
#include <utility>

#include "knead/io/append_file.h"
#include "knead/io/atomic_file.h"
#include "knead/math/error.h"
#include "knead/math/system.h"
#include "knead/session/journal_folder.h"

namespace knead {

namespace fs = std::filesystem;
using io_detail::AppendFile;
using session_detail::kSavedFile;
using session_detail::kSessionFile;

namespace {

// The lines of one batch.
class Batch {
 public:
  void add(const std::string& line) {
    if (!text_.empty()) text_ += " \n";  // the line before is not the last
    text_ += line;
  }
  std::string finish() && {
    if (!text_.empty()) text_ += "\n";
    return std::move(text_);
  }

 private:
  std::string text_;
};

[[noreturn]] void fail(const fs::path& folder, int error) {
  throw IoError(IoError::Operation::write, folder.string(),
                "the folder cannot be made (" + std::generic_category().message(error) +
                    "); check its permissions and the free space");
}

// A folder of its own that is not seen as a journal yet, and what it will be called.
struct NewFolder {
  fs::path hidden;
  fs::path folder;
};

NewFolder make_folder(const fs::path& root) {
  std::error_code error;
  fs::create_directories(root, error);
  if (error) fail(root, error.value());
  const std::string name = fmt::format("{:%Y-%m-%dT%H-%M-%S}-{}", fmt::gmtime(std::time(nullptr)), ::getpid());
  for (int n = 1;; ++n) {
    NewFolder made{root / fmt::format(".{}-{}", name, n), root / fmt::format("{}-{}", name, n)};
    if (fs::exists(made.folder, error)) continue;
    if (::mkdir(made.hidden.c_str(), 0700) == 0) return made;
    if (errno != EEXIST) fail(root, errno);
  }
}

// Writes the shape, and returns the name of its file.
std::string write_original(const fs::path& folder, const ShapeFile& shape) {
  const bool computed = shape.bytes.empty();
  std::string name = "shape." + (computed ? "ply" : shape.format);
  write_file_atomically(folder / name,
                        computed ? serialize_mesh("ply", shape.mesh, {.double_coordinates = true}) : shape.bytes);
  return name;
}

}  // namespace

Journal::Journal(fs::path folder, std::unique_ptr<AppendFile> file)
    : folder_(std::move(folder)), file_(std::move(file)) {}
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

Journal Journal::create(const fs::path& root, const ShapeFile& shape, const std::string& title) {
  const NewFolder made = make_folder(root);
  try {
    const std::string name = write_original(made.hidden, shape);
    auto file = std::make_unique<AppendFile>(made.hidden / kSessionFile);
    file->append(header_line(name, title) + "\n");
    if (const auto trouble = file->trouble()) {
      throw IoError(IoError::Operation::write, (made.folder / kSessionFile).string(),
                    "cannot be written (" + *trouble + "); free some space");
    }
    if (!kMovesOpenFolders) file.reset();
    if (::rename(made.hidden.c_str(), made.folder.c_str()) != 0) fail(made.folder, errno);
    if (!file) file = std::make_unique<AppendFile>(made.folder / kSessionFile);
    return {made.folder, std::move(file)};
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(made.hidden, ignored);
    throw;
  }
}

Journal Journal::attach(const fs::path& folder) {
  const fs::path path = folder / kSessionFile;
  session_detail::read_journal(folder);  // throws where there is none, before the lock would make the file
  Journal journal(folder, std::make_unique<AppendFile>(path));
  const std::string text = session_detail::read_journal(folder);
  journal.strokes_ = parse_session(text, path.string()).strokes.size();
  journal.remesh_.reset();
  journal.file_->cut(text.size());
  return journal;
}

void Journal::append(std::span<const SessionStroke> strokes) { replace(0, strokes); }

void Journal::take_back(std::size_t n) { replace(n, {}); }

void Journal::replace(std::size_t n, std::span<const SessionStroke> strokes) {
  if (n > strokes_) {
    throw InvalidInput(fmt::format("the journal holds {} strokes, {} cannot be taken back", strokes_, n));
  }
  Batch batch;
  if (n > 0) batch.add(fmt::format("{{\"undo\": {}}}", n));
  for (const SessionStroke& stroke : strokes) {
    if (!remesh_ || *remesh_ != stroke.remesh) batch.add(remesh_line(stroke.remesh));
    remesh_ = stroke.remesh;
    batch.add(stroke_line(stroke));
  }
  strokes_ = strokes_ - n + strokes.size();
  const std::string text = std::move(batch).finish();
  if (!text.empty()) file_->append(text);
}

void Journal::sync() { file_->sync(); }

std::optional<std::string> Journal::trouble() const {
  const std::optional<std::string> trouble = file_ ? file_->trouble() : std::nullopt;
  if (!trouble) return std::nullopt;
  return fmt::format("The journal cannot be written ({}): work goes on in memory; make room in {} or save.", *trouble,
                     folder_.string());
}

void Journal::note_saved(const fs::path& file) const {
  std::error_code error;  // without the note the work is offered once too often
  const std::uintmax_t length = fs::file_size(folder_ / kSessionFile, error);
  const fs::path saved = fs::absolute(file, error);
  if (error || file_->trouble()) return;
  std::ofstream(folder_ / kSavedFile, std::ios::binary) << length << "\n" << saved.string() << "\n";
}

void Journal::discard() {
  if (!kMovesOpenFolders) file_.reset();  // nor removes them
  std::error_code ignored;                // an unsaved folder too many is offered at the next start
  fs::remove_all(folder_, ignored);
}

}  // namespace knead
