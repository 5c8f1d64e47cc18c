#pragma once
// What is refused, and the words of its message.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace calor {

/// The error that `work` throws; none is a failure.
inline Error error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e;
  }
  ADD_FAILURE() << "nothing was refused";
  return Error(Fault::command, "", "");
}

/// That the text contains all of `words`.
inline void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(text.find(word), std::string::npos) << "'" << word << "' in: " << text;
}

/// That `work` throws an error of that kind, with a message that contains all of `words`.
inline void expect_error(const std::function<void()>& work, const std::vector<std::string>& words,
                         Fault fault = Fault::bad_case) {
  const Error error = error_of(work);
  EXPECT_EQ(error.fault(), fault) << error.what();
  expect_words(error.what(), words);
}

}  // namespace calor
