#include "process.h"

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace knead::command_test {
namespace {

namespace fs = std::filesystem;

fs::path fresh_folder() {
  std::string name = (fs::temp_directory_path() / "knead-command-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  return name;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

int open_for_writing(const fs::path& path) { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600); }

struct Streams {
  int out = -1;
  int err = -1;
};

[[noreturn]] void become_command(const std::vector<std::string>& arguments, const fs::path& folder,
                                 const RunOptions& options, const Streams& streams) {
  ::dup2(streams.out, STDOUT_FILENO);
  ::dup2(streams.err, STDERR_FILENO);
  if (::chdir(folder.c_str()) != 0) ::_exit(126);
  for (const std::string& variable : options.environment) {
    const std::size_t equals = variable.find('=');
    ::setenv(variable.substr(0, equals).c_str(), variable.substr(equals + 1).c_str(), 1);
  }
  std::string command = KNEAD_COMMAND;
  std::vector<std::string> words = arguments;
  std::vector<char*> argv{command.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(command.c_str(), argv.data());
  ::_exit(127);
}

int unread_pipe() {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  ::close(ends[0]);
  return ends[1];
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments, const fs::path& folder, const RunOptions& options)
    : streams_(fresh_folder()) {
  Streams streams;
  streams.out = options.closed_pipe
                    ? unread_pipe()
                    : open_for_writing(options.stdout_path.empty() ? streams_ / "out" : fs::path(options.stdout_path));
  if (options.stderr_is_terminal) {
    if (::openpty(&terminal_, &streams.err, nullptr, nullptr, nullptr) != 0) throw std::runtime_error("no terminal");
  } else {
    streams.err = open_for_writing(streams_ / "err");
  }
  id_ = ::fork();
  if (id_ == 0) {
    const int in = options.stdin_path.empty() ? -1 : ::open(options.stdin_path.c_str(), O_RDONLY);
    if (in >= 0) ::dup2(in, STDIN_FILENO);
    become_command(arguments, folder, options, streams);
  }
  ::close(streams.out);
  ::close(streams.err);
}

Process::~Process() {
  if (!waited_) {
    send(SIGKILL);
    ::waitpid(id_, nullptr, 0);
  }
  if (terminal_ >= 0) ::close(terminal_);
  fs::remove_all(streams_);
}

void Process::send(int signal) const { ::kill(id_, signal); }

Outcome Process::wait() {
  Outcome outcome;
  std::array<char, 4096> buffer{};
  while (terminal_ >= 0) {
    const ssize_t count = ::read(terminal_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;  // EIO: the other side is closed
    outcome.err.append(buffer.data(), static_cast<std::size_t>(count));
  }
  int status = 0;
  ::waitpid(id_, &status, 0);
  waited_ = true;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  outcome.out = bytes_of(streams_ / "out");
  if (terminal_ < 0) outcome.err = bytes_of(streams_ / "err");
  return outcome;
}

CommandTest::CommandTest() : folder_(fresh_folder()) {}
CommandTest::~CommandTest() { fs::remove_all(folder_); }

Outcome CommandTest::knead(const std::vector<std::string>& arguments, const RunOptions& options) const {
  return Process(arguments, folder_, options).wait();
}

std::string CommandTest::knead_ok(const std::vector<std::string>& arguments) const {
  const Outcome outcome = knead(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

void CommandTest::write(const std::string& name, const std::string& text) const {
  std::ofstream(path(name), std::ios::binary) << text;
}

std::string CommandTest::read(const std::string& name) const { return bytes_of(path(name)); }

std::vector<std::string> CommandTest::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void expect_error(const Outcome& outcome, int exit_code, const std::string& part) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(outcome.err.starts_with("knead: ")) << outcome.err;
  EXPECT_TRUE(outcome.err.ends_with("\n")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err << "should say: " << part;
}

}  // namespace knead::command_test
