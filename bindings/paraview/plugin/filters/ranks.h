// The exchange of numbers and messages between the ranks of a parallel ParaView.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "knead/vec.h"

class vtkMultiProcessController;

namespace knead::paraview {

// The failure that stops the filter, the same on all ranks. An empty message: it was cancelled.
class Failure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The ranks of a controller. All ranks must call the same functions in the same order. ParaView's timer log has the
// time in the controller as "Knead: exchange", with the wait for the slowest rank.
class Ranks {
 public:
  // Null: there is one rank.
  explicit Ranks(vtkMultiProcessController* controller) : controller_(controller) {}

  int rank() const;
  int count() const;

  // Does the work on each rank. Throws Failure on all ranks if it throws on any, with the message of the lowest one.
  void together(const std::function<void()>& work) const;

  std::int64_t sum(std::int64_t number) const;
  Box united(const Box& box) const;
  // Returns the numbers of all ranks, one rank after the other.
  std::vector<double> gathered(std::vector<double> own) const;

  // Returns the text of the lowest rank that gives one that is not empty; else an empty one.
  std::string first(const std::string& text) const;

 private:
  int least(int number) const;
  std::string sent_from(int rank, std::string text) const;

  vtkMultiProcessController* controller_;
};

}  // namespace knead::paraview
