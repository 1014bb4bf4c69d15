// Writes files: a locked one that grows (AppendFile), and others as a whole (AtomicFile).
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "io/append_file.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"

namespace knead {
namespace {

constexpr std::chrono::seconds kBetweenAttempts{1};

[[noreturn]] void refuse(const std::filesystem::path& path, const char* what, int error) {
  throw IoError(IoError::Operation::write, path.string(),
                std::string(what) + " (" + std::generic_category().message(error) +
                    "); check the folder, its permissions and the free space");
}

// The errno of failing to write all of the text, 0 where it is written.
int write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

// Of this thread; null: files take their places as they are finished.
thread_local FilesTogether* together = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// The temporary paths in use, in memory that a signal handler may read.
struct Slot {
  static constexpr std::size_t kSize = 4096;

  std::atomic<bool> taken = false;
  std::atomic<bool> armed = false;  // `path` names a file to be removed
  std::atomic<bool> created = false;
  std::array<char, kSize> path{};
};
std::array<Slot, 1024> slots;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): for signal handlers
static_assert(std::atomic<bool>::is_always_lock_free);
std::atomic<std::size_t> files_in_place = 0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
static_assert(std::atomic<std::size_t>::is_always_lock_free);

// Removes a temporary file at the end of its scope unless it was renamed before.
class TemporaryName {
 public:
  explicit TemporaryName(const std::filesystem::path& path) : path_(path), slot_(take_slot()) {
    const std::string text = path.string();
    if (slot_ == nullptr || text.size() >= Slot::kSize) return;
    std::memcpy(slot_->path.data(), text.c_str(), text.size() + 1);
    slot_->armed = true;
  }
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;
  ~TemporaryName() {
    if (!renamed_) ::unlink(path_.c_str());
    if (slot_ == nullptr) return;
    slot_->armed = false;
    slot_->created = false;
    slot_->taken = false;
  }

  void set_created() {
    if (slot_ != nullptr) slot_->created = true;
  }
  void set_renamed() {
    renamed_ = true;
    ++files_in_place;
  }

 private:
  static Slot* take_slot() {
    for (Slot& slot : slots) {
      if (!slot.taken.exchange(true)) return &slot;
    }
    return nullptr;  // more writers than slots: still removed on failure, but not on a signal
  }

  std::filesystem::path path_;
  Slot* slot_;
  bool renamed_ = false;
};

// A file descriptor that is closed once.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  int number() const { return number_; }
  bool close() {
    const int number = number_;
    number_ = -1;
    return number < 0 || ::close(number) == 0;
  }

 private:
  int number_;
};

constexpr std::string_view kPrefix = ".knead-";
constexpr std::string_view kSuffix = ".tmp";
constexpr std::size_t kKeyLength = 16;

std::string random_key(std::size_t length) {
  constexpr std::string_view digits = "0123456789abcdefghijklmnopqrstuvwxyz";
  std::random_device random;
  std::string key;
  for (std::size_t i = 0; i < length; ++i) key += digits[random() % digits.size()];
  return key;
}

// The name in the target's folder under which it is written first. A part has the key of the whole before its own.
std::filesystem::path temporary_path(const std::filesystem::path& target, const std::filesystem::path& whole) {
  std::string key = random_key(kKeyLength);
  if (!whole.empty()) key = whole.filename().string().substr(kPrefix.size(), kKeyLength) + "-" + key;
  return target.parent_path() / fmt::format("{}{}{}", kPrefix, key, kSuffix);
}

// Returns the key of the whole that a temporary file belongs to; empty for another file.
std::string key_of(const std::string& name) {
  const bool is_own = name.starts_with(kPrefix) && name.ends_with(kSuffix) &&
                      name.size() >= kPrefix.size() + kKeyLength + kSuffix.size();
  return is_own ? name.substr(kPrefix.size(), kKeyLength) : std::string();
}

void sync_folder(const std::filesystem::path& folder) {
  Descriptor file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (file.number() >= 0) ::fsync(file.number());  // where folders cannot be synced, the rename still stands
}

}  // namespace
}  // namespace knead

namespace knead::detail {

#if defined(__EMSCRIPTEN__)

// Files of a page are in memory; the page itself stores them.
class AppendFile::Syncer {
 public:
  explicit Syncer(int) {}
  void request() {}
  int error() const { return 0; }
};

#else

// A thread that syncs the file on request; joins the requests that arrive during a sync.
class AppendFile::Syncer {
 public:
  explicit Syncer(int file) : file_(file), thread_([this] { run(); }) {}
  Syncer(const Syncer&) = delete;
  Syncer& operator=(const Syncer&) = delete;
  ~Syncer() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

  void request() {
    {
      const std::lock_guard lock(mutex_);
      requested_ = true;
    }
    changed_.notify_one();
  }

  int error() const { return error_; }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return requested_ || ended_; });
      if (!requested_) return;
      requested_ = false;
      lock.unlock();
      error_ = sync_data(file_) == 0 ? 0 : errno;
      lock.lock();
    }
  }

  int file_;
  std::atomic<int> error_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool requested_ = false;
  bool ended_ = false;
  std::thread thread_;  // last: it uses the others
};

#endif

AppendFile::AppendFile(const std::filesystem::path& path)
    : path_(path.string()), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600)) {
  if (file_ < 0) refuse(path_, "cannot be opened for writing", errno);
  const off_t size = ::lseek(file_, 0, SEEK_END);
  if (size >= 0 && ::flock(file_, LOCK_EX | LOCK_NB) == 0) {
    length_ = static_cast<std::size_t>(size);
    return;
  }
  const int error = errno;
  ::close(file_);
  if (error != EWOULDBLOCK) refuse(path_, "cannot be locked", error);
  throw InvalidInput({path_}, "is in use by another program; close that first");
}

AppendFile::~AppendFile() {
  if (!waiting_.empty()) write_waiting();
  syncer_.reset();
  ::close(file_);
}

void AppendFile::cut(std::size_t length) {
  if (length >= length_) return;
  if (::ftruncate(file_, static_cast<off_t>(length)) != 0) refuse(path_, "cannot be cut to its whole part", errno);
  length_ = length;
}

void AppendFile::append(std::string_view text) {
  waiting_ += text;
  if (error_ == 0 || std::chrono::steady_clock::now() >= next_attempt_) write_waiting();
}

void AppendFile::write_waiting() {
  if (torn_ && ::ftruncate(file_, static_cast<off_t>(length_)) != 0) return fail(errno);
  torn_ = true;
  if (const int error = write_all(file_, waiting_); error != 0) {
    torn_ = ::ftruncate(file_, static_cast<off_t>(length_)) != 0;
    return fail(error);
  }
  torn_ = false;
  length_ += waiting_.size();
  waiting_.clear();
  error_ = 0;
}

void AppendFile::fail(int error) {
  error_ = error;
  next_attempt_ = std::chrono::steady_clock::now() + kBetweenAttempts;
}

void AppendFile::sync() {
  if (error_ != 0) append({});
  try {
    if (syncer_ == nullptr) syncer_ = std::make_unique<Syncer>(file_);
    syncer_->request();
  } catch (const std::system_error& error) {  // no more threads: the system syncs in its own time
    fail(error.code().value());
  }
}

std::optional<std::string> AppendFile::trouble() const {
  const int error = error_ != 0 || syncer_ == nullptr ? error_ : syncer_->error();
  if (error == 0) return std::nullopt;
  return std::generic_category().message(error);
}

}  // namespace knead::detail

namespace knead {

std::filesystem::path followed_link(const std::filesystem::path& path) {
  constexpr int most = 40;  // links after each other, as for the system itself
  std::error_code error;
  std::filesystem::path target = path;
  for (int i = 0; i < most; ++i) {
    const std::filesystem::path next = std::filesystem::read_symlink(target, error);
    if (error) break;  // no link
    target = target.parent_path() / next;
  }
  const std::filesystem::path whole = std::filesystem::weakly_canonical(target, error);
  return error ? target : whole;
}

struct AtomicFile::Parts {
  std::filesystem::path path;       // for messages
  std::filesystem::path target;     // of the links at its end
  std::filesystem::path temporary;  // empty: the target is no regular file, and is written directly
  std::optional<TemporaryName> name;
  std::optional<Descriptor> file;

  Parts(const std::filesystem::path& of, const std::filesystem::path& whole) : path(of), target(followed_link(of)) {
    struct stat old {};
    const bool exists = ::stat(target.c_str(), &old) == 0;
    if (exists && S_ISDIR(old.st_mode)) refuse(path, "is a folder", EISDIR);
    if (exists && !S_ISREG(old.st_mode)) {
      file.emplace(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
      if (file->number() < 0) refuse(path, "cannot be opened for writing", errno);
      return;
    }
    if (exists && ::access(target.c_str(), W_OK) != 0) refuse(path, "cannot be overwritten", errno);
    const bool is_beside = whole.parent_path() == target.parent_path();
    temporary = temporary_path(target, is_beside ? whole : std::filesystem::path());
    name.emplace(temporary);
    file.emplace(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file->number() < 0) refuse(path, "cannot be created", errno);
    ::flock(file->number(), LOCK_EX | LOCK_NB);  // for discard_abandoned_files()
    name->set_created();
    if (exists) ::fchmod(file->number(), old.st_mode & 07777);  // best effort: the contents matter more
  }
};

AtomicFile::AtomicFile(const std::filesystem::path& path)
    : parts_(std::make_unique<Parts>(path, together != nullptr ? together->first_ : std::filesystem::path())) {
  if (together != nullptr && together->first_.empty()) together->first_ = parts_->temporary;
}
AtomicFile::AtomicFile(const std::filesystem::path& path, const AtomicFile& whole)
    : parts_(std::make_unique<Parts>(path, whole.parts_->temporary)) {}
AtomicFile::~AtomicFile() = default;
AtomicFile::AtomicFile(AtomicFile&&) noexcept = default;
AtomicFile& AtomicFile::operator=(AtomicFile&&) noexcept = default;

void AtomicFile::write(std::string_view bytes) {
  const int error = write_all(parts_->file->number(), bytes);
  if (error != 0) refuse(parts_->path, "cannot be written", error);
}

void AtomicFile::close() {
  if (!parts_->file) return;
  const bool is_synced = parts_->temporary.empty() || ::fsync(parts_->file->number()) == 0;
  if (!is_synced || !parts_->file->close()) refuse(parts_->path, "cannot be written", errno);
  parts_->file.reset();
}

void AtomicFile::finish() {
  if (together != nullptr && !parts_->temporary.empty()) {
    // The first one stays open: its lock says of all that they are not abandoned.
    if (parts_->temporary != together->first_) close();
    together->waiting_.push_back(std::move(*this));
    return;
  }
  close();
  if (parts_->temporary.empty()) {
    ++files_in_place;
    return;
  }
  if (::rename(parts_->temporary.c_str(), parts_->target.c_str()) != 0)
    refuse(parts_->path, "cannot be replaced", errno);
  parts_->name->set_renamed();
  sync_folder(parts_->target.parent_path());
}

FilesTogether::FilesTogether() { together = this; }

FilesTogether::~FilesTogether() {
  if (together == this) together = nullptr;
}

void FilesTogether::finish() {
  together = nullptr;
  for (AtomicFile& file : waiting_) file.close();  // what cannot be written is found before any of them is in place
  for (AtomicFile& file : waiting_) file.finish();
  waiting_.clear();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.finish();
}

// The lock of the whole says whether the program that writes it runs. Its parts are closed before.
void discard_abandoned_files(const std::filesystem::path& folder) noexcept {
  try {
    std::vector<std::pair<std::string, std::filesystem::path>> files;
    std::error_code error;
    for (auto entry = std::filesystem::directory_iterator(folder.empty() ? "." : folder, error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
      const std::string key = key_of(entry->path().filename().string());
      if (!key.empty()) files.emplace_back(key, entry->path());
    }
    std::set<std::string> running;
    for (const auto& [key, path] : files) {
      Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
      const bool is_free = file.number() >= 0 && ::flock(file.number(), LOCK_EX | LOCK_NB) == 0;
      if (!is_free) running.insert(key);
    }
    for (const auto& [key, path] : files) {
      if (!running.contains(key)) ::unlink(path.c_str());
    }
  } catch (const std::exception&) {
    return;  // of a folder that cannot be listed nothing is removed
  }
}

void discard_unfinished_files() noexcept {
  for (Slot& slot : slots) {
    if (slot.armed) ::unlink(slot.path.data());
  }
}

std::size_t count_files_in_place() noexcept {
  std::size_t count = files_in_place;
  for (Slot& slot : slots) {
    const bool is_gone = slot.armed && slot.created && ::access(slot.path.data(), F_OK) != 0;
    if (is_gone) ++count;  // renamed, perhaps counted as well
  }
  return count;
}

}  // namespace knead
