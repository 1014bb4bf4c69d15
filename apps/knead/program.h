// The command's calls of the system: Linux, macOS or Windows. Their differences are here and, for the library, in
// math/system.h; no other source asks which system it is on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace knead::command {

// Returns 0 if a file can be made in this folder, else the error (errno). Leaves nothing behind.
int error_of_making_files_in(const std::filesystem::path& folder);

// Returns 0 if this file may be overwritten, else the error (errno).
int error_of_overwriting(const std::filesystem::path& file);

// Bytes of memory that this machine has; the largest number where the system does not say.
std::uint64_t memory_bytes() noexcept;

// Bytes that the stack of the first thread may grow to; the largest number where the system does not say.
std::uint64_t stack_bytes() noexcept;

// To be called first: standard input and output pass every byte as it is, and what cannot be written is an error where
// it is written, not the end of the program.
void prepare_process() noexcept;

// Calls `handle` when the user or the system wants the program to end: as a signal handler, on Windows in a thread of
// its own.
void when_interrupted(void (*handle)(int signal));

// Whether the error output is a terminal that can go back to the begin of a line.
bool shows_progress() noexcept;

// For signal handlers: writes to the error output; ends the process without cleaning up.
void write_error_output(std::string_view text) noexcept;
[[noreturn]] void end_process(int code) noexcept;

// The file of the program that runs; empty where the system does not say.
std::filesystem::path own_program();

// Returns the file of a program on PATH; empty if there is none.
std::filesystem::path find_program(const std::string& name);

// Becomes another program, found on PATH if it has no folder; words[0] is its name. Returns if there is no such
// program.
void become(const std::filesystem::path& program, std::vector<std::string> words);

// Another program that runs beside this one and makes bytes of the bytes that it is given.
class PipedProgram {
 public:
  // Starts a program that is found on PATH, with these words after its name.
  PipedProgram(const std::string& name, const std::vector<std::string>& words);
  ~PipedProgram();
  PipedProgram(const PipedProgram&) = delete;
  PipedProgram& operator=(const PipedProgram&) = delete;

  // Whether it was started and has not been finished.
  bool is_running() const;

  // Gives bytes to its standard input. Returns false if it has ended.
  bool write(const void* bytes, std::size_t count);

  // Ends its input and waits for its end. Returns its status: 0 if it did its work, or was never started.
  int finish();

  // What it has written to its standard output; complete after finish().
  const std::string& output() const;

 private:
  struct State;
  std::unique_ptr<State> state_;  // null: it was not started
};

}  // namespace knead::command
