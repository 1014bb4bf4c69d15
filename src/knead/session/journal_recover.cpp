#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "knead/math/error.h"
#include "knead/math/system.h"
#include "knead/session/journal.h"
#include "knead/session/journal_folder.h"
#include "knead/session/workbench.h"

namespace knead {

namespace fs = std::filesystem;
using session_detail::kSavedFile;
using session_detail::kSessionFile;

namespace {

// The file of a journal that nobody else holds, locked for as long as this lives.
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

Session read_whole(const fs::path& folder) {
  return parse_session(session_detail::read_journal(folder), (folder / kSessionFile).string());
}

bool is_saved(const fs::path& folder) {
  std::ifstream note(folder / kSavedFile, std::ios::binary);
  std::uintmax_t length = 0;
  std::string file;
  std::error_code error;
  if (!(note >> length) || !std::getline(note >> std::ws, file)) return false;
  return fs::file_size(folder / kSessionFile, error) == length && fs::exists(file, error);
}

AbandonedJournal describe(const fs::path& folder, const Unheld& file) {
  AbandonedJournal journal{folder, folder.filename().string(), file.changed()};
  journal.is_saved = is_saved(folder);
  try {
    const Session session = read_whole(folder);
    if (session.note) journal.title = *session.note;
    journal.strokes = session.strokes.size();
    journal.entries = strokes_of_gestures(session.strokes).size();
    if (!session.mesh || !fs::exists(folder / *session.mesh)) journal.problem = "the shape it was made on is missing";
  } catch (const std::exception& error) {
    journal.problem = error.what();
  }
  return journal;
}

}  // namespace

namespace session_detail {

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

}  // namespace session_detail

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
  return work;
}

void discard_journal(const fs::path& folder) {
  std::error_code ignored;
  {
    const Unheld file(folder);
    if (!file.is_file() || file.held()) return;
    fs::remove(folder / kSessionFile, ignored);  // while nobody else can take it up
  }
  fs::remove_all(folder, ignored);
}

}  // namespace knead
