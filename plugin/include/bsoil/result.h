/// Result<T>: a value, or a sentence that says what is wrong. Nothing in BulletSoil throws.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

#include "bsoil/cxx20.h"

namespace bsoil {

/// What went wrong: names the field, its value and the accepted range.
struct Error {
    std::string text;
};

/// A value or an Error. Reading the value of a failed result is a programming error (assert).
template <typename T>
class [[nodiscard]] Result {
  public:
    /// A success.
    Result(T value) : value_(std::move(value)) {}
    /// A failure.
    Result(Error error) : error_(std::move(error.text)) {}

    /// Whether there is a value.
    /// @{
    explicit operator bool() const { return value_.has_value(); }
    bool ok() const { return value_.has_value(); }
    /// @}
    /// What went wrong; empty where there is a value.
    const std::string& error() const { return error_; }

    /// The value, which has to be there.
    /// @{
    T& value() {
        assert(value_);
        return *value_;
    }
    const T& value() const {
        assert(value_);
        return *value_;
    }
    T& operator*() { return value(); }
    const T& operator*() const { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    /// @}

  private:
    std::optional<T> value_;
    std::string error_;
};

/// Success without a value.
struct Done {};
/// The result of an operation that gives nothing back.
using Status = Result<Done>;

}  // namespace bsoil
