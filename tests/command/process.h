// Runs the built command, and the fixture of the tests that do.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace knead::command_test {

struct Outcome {
  int exit_code = -1;  // negative: ended by that signal
  std::string out;
  std::string err;
};

struct RunOptions {
  std::vector<std::string> environment{};  // "NAME=value", added to this process's own
  std::string stdin_path{};                // a file that is its standard input; empty: this process's own
  std::string stdout_path{};               // instead of being caught
  bool stderr_is_terminal = false;         // a pseudo-terminal
  bool closed_pipe = false;                // standard output is a pipe that nobody reads
};

// One run of the command, in `folder`.
class Process {
 public:
  Process(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const RunOptions& options = {});
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  pid_t id() const { return id_; }
  void send(int signal) const;
  Outcome wait();

 private:
  pid_t id_ = -1;
  int terminal_ = -1;
  std::filesystem::path streams_;  // a folder outside of the one that the command works in
  bool waited_ = false;
};

// A fresh folder for each test, in which the command runs.
class CommandTest : public ::testing::Test {
 protected:
  CommandTest();
  ~CommandTest() override;

  Outcome knead(const std::vector<std::string>& arguments, const RunOptions& options = {}) const;

  // The same, for what must succeed without a word on standard error.
  std::string knead_ok(const std::vector<std::string>& arguments) const;

  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& text) const;
  std::string read(const std::string& name) const;
  std::vector<std::string> files() const;  // sorted

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

// The one line that every error is: exit code, "knead: " in front, nothing on standard output.
void expect_error(const Outcome& outcome, int exit_code, const std::string& part);

// Sessions.
inline const std::string kNoStrokes = "{\"knead\": 1}\n";
inline const std::string kOneStroke =
    "{\"knead\": 1}\n"
    "{\"tool\": \"implicit\", \"inner\": 0.3, \"outer\": 0.9, \"path\": [[0.9, 0, 0], [1.3, 0.2, 0], [1.5, 0.3, "
    "0.1]]}\n";
inline const std::string kTwoStrokes = kOneStroke +
                                       "{\"tool\": \"twist\", \"center\": [0, 0, 0], \"axis\": [0, 1, 0], "
                                       "\"rate_deg\": 30, \"inner\": -0.5, \"outer\": 0.5}\n";

}  // namespace knead::command_test
