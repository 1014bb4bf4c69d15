#include "knead/io/append_file.h"

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#include "knead/math/error.h"
#include "knead/math/system.h"

namespace knead::io_detail {

namespace {

constexpr std::chrono::seconds kBetweenAttempts{1};

[[noreturn]] void refuse(const std::string& path, const char* what, int error) {
  throw IoError(IoError::Operation::write, path,
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

}  // namespace

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

}  // namespace knead::io_detail
