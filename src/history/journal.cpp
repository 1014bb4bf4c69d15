// The journal of an editor: a session file that is written stroke by stroke, and its recovery.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "history/history.h"
#include "io/append_file.h"
#include "knead/editor/shape_state.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/session.h"
#include "math/system.h"

namespace knead {

namespace fs = std::filesystem;
using namespace detail;

namespace {

// The file of a journal that no other process holds; locked for the lifetime of this object.
class Unheld {
 public:
  explicit Unheld(const fs::path& folder)
      : file_(::open((folder / kSessionFile).c_str(), O_RDONLY | O_CLOEXEC)),
        held_(file_ >= 0 && ::flock(file_, LOCK_EX | LOCK_NB) != 0) {}
  Unheld(const Unheld&) = delete;
  Unheld& operator=(const Unheld&) = delete;
  ~Unheld() {
    if (file_ >= 0) ::close(file_);
  }

  bool is_file() const { return file_ >= 0; }
  bool held() const { return held_; }  // by another program
  std::chrono::system_clock::time_point changed() const {
    struct stat state {};
    if (file_ < 0 || ::fstat(file_, &state) != 0) return {};
    const auto since = std::chrono::nanoseconds(changed_ns(file_, state));
    return std::chrono::system_clock::time_point(
        std::chrono::duration_cast<std::chrono::system_clock::duration>(since));
  }

 private:
  int file_;
  bool held_;
};

// Returns the session of a journal. Joins the pieces of a stroke that was growing when the program ended
// (Workbench::live_lines); a finished stroke has no pieces.
Session read_whole(const fs::path& folder) {
  Session session = parse_session(detail::read_journal(folder), (folder / kSessionFile).string());
  session.strokes =
      detail::joined_where(std::move(session.strokes), [](const SessionStroke& before, const SessionStroke& stroke) {
        return stroke.new_entry == false && stroke.remesh && stroke.remesh == before.remesh;
      });
  return session;
}

// The contents of kSavedFile; an empty path if it has none.
struct SavedNote {
  std::uintmax_t length = 0;
  fs::path file;
};

SavedNote read_saved_note(const fs::path& folder) {
  std::ifstream note(folder / kSavedFile, std::ios::binary);
  std::uintmax_t length = 0;
  std::string file;
  if (!(note >> length) || !std::getline(note >> std::ws, file)) return {};
  return {length, file};
}

bool is_saved(const fs::path& folder) {
  const SavedNote note = read_saved_note(folder);
  std::error_code error;
  return fs::file_size(folder / kSessionFile, error) == note.length && fs::exists(note.file, error);
}

std::string bytes_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Returns the file of each shape of the work (RecoveredWork::files).
std::vector<fs::path> files_of(const RecoveredWork& work) {
  std::vector<fs::path> files(1 + work.also.size());
  try {
    const Session saved = read_session(work.saved);
    for (std::size_t i = 0; i < files.size() && i <= saved.also.size(); ++i) {
      if (i == 0 && !saved.mesh) continue;
      const fs::path path = work.saved.parent_path() / (i == 0 ? *saved.mesh : saved.also[i - 1]);
      if (bytes_of_file(path) == (i == 0 ? work.shape : work.also[i - 1]).bytes) files[i] = path;
    }
  } catch (const std::exception&) {
    return files;  // the saved session is gone: the journal has the shapes
  }
  return files;
}

AbandonedJournal describe(const fs::path& folder, const Unheld& file) {
  AbandonedJournal journal{folder, folder.filename().string(), file.changed()};
  journal.is_saved = is_saved(folder);
  try {
    const Session session = read_whole(folder);
    if (session.note) journal.title = *session.note;
    journal.strokes = session.strokes.size();
    journal.entries = strokes_of_gestures(session.strokes).size();
    const auto is_there = [&](const std::string& name) { return fs::exists(folder / name); };
    if (!session.mesh || !is_there(*session.mesh) || !std::all_of(session.also.begin(), session.also.end(), is_there)) {
      journal.problem = "the shape it was made on is missing";
    }
  } catch (const std::exception& error) {
    journal.problem = error.what();
  }
  return journal;
}

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

// Writes the shape, and returns the name of its file. `number`: from 1.
std::string write_original(const fs::path& folder, const ShapeFile& shape, std::size_t number) {
  const bool computed = shape.bytes.empty();
  std::string name =
      fmt::format("shape{}.{}", number == 1 ? "" : fmt::format("_{}", number), computed ? "ply" : shape.format);
  write_file_atomically(folder / name,
                        computed ? serialize_mesh("ply", shape.mesh, {.double_coordinates = true}) : shape.bytes);
  return name;
}

}  // namespace

namespace detail {

std::string read_journal(const fs::path& folder) {
  const fs::path path = folder / kSessionFile;
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) {
    throw IoError(IoError::Operation::read, path.string(), "cannot be read: " + std::generic_category().message(errno));
  }
  text.resize(whole_batches(text).size());
  if (text.empty()) throw InvalidInput({path.string()}, "holds no header of a journal; there is nothing to recover");
  return text;
}

}  // namespace detail

std::string_view whole_batches(std::string_view text) {
  std::size_t end = text.rfind('\n');
  while (end != std::string_view::npos && end > 0 && text[end - 1] == ' ') end = text.rfind('\n', end - 1);
  return text.substr(0, end == std::string_view::npos ? 0 : end + 1);
}

std::vector<AbandonedJournal> abandoned_journals(const fs::path& root) {
  std::vector<AbandonedJournal> journals;
  std::error_code error;
  for (auto entry = fs::directory_iterator(root, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const fs::path& folder = entry->path();
    if (folder.filename().string().starts_with('.')) continue;  // of a journal that is being made
    const Unheld file(folder);
    if (file.is_file() && !file.held()) journals.push_back(describe(folder, file));
  }
  std::sort(journals.begin(), journals.end(), [](const AbandonedJournal& a, const AbandonedJournal& b) {
    return a.changed != b.changed ? a.changed > b.changed : a.folder > b.folder;
  });
  return journals;
}

RecoveredWork recover_journal(const fs::path& folder) {
  RecoveredWork work;
  work.session = read_whole(folder);
  if (!work.session.mesh) {
    throw InvalidInput({work.session.name, 1}, "\"mesh\" is missing; the header must name the shape it was made on");
  }
  work.title = work.session.note.value_or(folder.filename().string());
  work.shape = read_shape(folder / *work.session.mesh);
  for (const std::string& name : work.session.also) work.also.push_back(read_shape(folder / name));
  work.saved = read_saved_note(folder).file;
  work.files = files_of(work);
  return work;
}

void discard_journal(const fs::path& folder) {
  std::error_code ignored;
  {
    const Unheld file(folder);
    if (!file.is_file() || file.held()) return;
    fs::remove(folder / kSessionFile, ignored);  // while no other process can lock it
  }
  fs::remove_all(folder, ignored);
}

Journal::Journal(fs::path folder, std::unique_ptr<AppendFile> file)
    : folder_(std::move(folder)), file_(std::move(file)) {}
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

Journal Journal::create(const fs::path& root, const ShapeFile& shape, const std::string& title,
                        std::span<const std::shared_ptr<const ShapeFile>> also) {
  const NewFolder made = make_folder(root);
  try {
    const std::string name = write_original(made.hidden, shape, 1);
    std::vector<std::string> others;
    for (const auto& other : also) others.push_back(write_original(made.hidden, *other, others.size() + 2));
    auto file = std::make_unique<AppendFile>(made.hidden / kSessionFile);
    file->append(header_line(name, title, {}, others) + "\n");
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
  detail::read_journal(folder);  // throws where there is none, before the lock would make the file
  Journal journal(folder, std::make_unique<AppendFile>(path));
  const std::string text = detail::read_journal(folder);
  journal.strokes_ = parse_session(text, path.string()).strokes.size();
  journal.remesh_.reset();
  journal.file_->cut(text.size());
  return journal;
}

void Journal::append(std::span<const SessionStroke> strokes) { replace(0, strokes); }

void Journal::undo(std::size_t n) { replace(n, {}); }

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

void Journal::note_saved(const fs::path& file, bool holds_all) const {
  std::error_code error;  // without the note the work is offered once too often
  const std::uintmax_t length = holds_all ? fs::file_size(folder_ / kSessionFile, error) : 0;
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
