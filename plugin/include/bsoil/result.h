/// Result<T>: a value, or a sentence that says what is wrong. Nothing in BulletSoil throws.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace bsoil {

/// What went wrong: names the field, its value and the accepted range.
struct Error {
    std::string text;
};

/// A value or an Error. Reading the value of a failed result is a programming error (assert).
template <typename T>
class [[nodiscard]] Result {
  public:
    Result(T value) : value_(std::move(value)) {}
    Result(Error error) : error_(std::move(error.text)) {}

    explicit operator bool() const { return value_.has_value(); }
    bool ok() const { return value_.has_value(); }
    const std::string& error() const { return error_; }

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

  private:
    std::optional<T> value_;
    std::string error_;
};

/// Success without a value.
struct Done {};
using Status = Result<Done>;

}  // namespace bsoil
