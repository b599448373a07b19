#include "toml_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "files/text_file.h"

namespace bsoil::scene {
namespace {

/// Walks through a text as TOML reads it, as far as it takes to tell a key's dots from others, and
/// what is quoted. Where the syntax is wrong it may lose its way: the parser stops there.
class KeyScanner {
  public:
    explicit KeyScanner(std::string_view text) : text_(text) {}

    struct Fault {
        size_t at = 0;
        std::string text;
    };

    /// The first place that the parser must not get to; none in most files. toml++ reads a value
    /// without quotes on to the next blank, comma or closing bracket, whatever is in it.
    std::optional<Fault> find_fault() {
        int dots = 0;
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // the mark of the byte order
        while (at_ < text_.size()) {
            // toml++ asks whether it is a blank, with undefined behaviour for most of them.
            if (!is_ascii(text_[at_])) {
                return Fault{at_, "characters beyond ASCII must be in quotes or comments"};
            }
            switch (text_[at_]) {
                case '#':
                    at_ = std::min(text_.find('\n', at_), text_.size());
                    break;
                case '"':
                case '\'':
                    if (is_bare_at(at_ - 1)) {
                        return Fault{at_,
                                     "a quote stands inside of a word; put all of it in quotes"};
                    }
                    if (const auto at = skip_string()) {
                        return Fault{*at, "behind a \\ this must be written as \\uXXXX"};
                    }
                    break;
                // Whatever stands between two keys or values.
                case '=':
                case '[':
                case '{':
                    if (is_value_ && is_bare_at(at_ - 1)) {
                        return Fault{at_,
                                     fmt::format("a `{}` stands inside of a word; put all of it in "
                                                 "quotes, or a comma before it",
                                                 text_[at_])};
                    }
                    [[fallthrough]];
                case ',':
                case ']':
                case '}':
                case '\n':
                    follow(text_[at_]);
                    dots = 0;
                    ++at_;
                    break;
                case '.':
                    if (++dots >= kKeyPartCapacity) {
                        return Fault{at_, fmt::format("a key has more than {} parts with dots "
                                                      "between them; leave some out",
                                                      kKeyPartCapacity)};
                    }
                    ++at_;
                    break;
                default:
                    ++at_;
            }
        }
        return {};
    }

  private:
    /// Whether a key or a value comes behind one of those.
    void follow(char c) {
        const bool is_inside = !open_.empty();
        switch (c) {
            case '=':
                is_value_ = true;
                break;
            case ',':
                if (is_inside) is_value_ = open_.back() == '[';
                break;
            case '\n':
                is_value_ = is_value_ && is_inside;
                break;
            case '[':
            case '{':
                if (is_value_) open_.push_back(c);  // else it is a table's head
                is_value_ = is_value_ && c == '[';
                break;
            default:
                if (is_inside) open_.pop_back();
                is_value_ = is_value_ || is_inside;
        }
    }
    static bool is_ascii(char c) { return (c & 128) == 0; }
    /// A letter, digit or sign of a key or value without quotes; a point is one of a number, and
    /// not of a key, whose parts may have quotes.
    bool is_bare_at(size_t at) const {
        if (at >= text_.size() || !is_ascii(text_[at])) return false;
        if (text_[at] == '.') return is_value_;
        return std::string_view(" \t\r\n=,[]{}\"'").find(text_[at]) == std::string_view::npos;
    }

    /// To behind the string that begins here. One that does not end is an error of syntax to come:
    /// nothing behind it matters. Returns the place of what toml++ must not get: it asks whether
    /// what follows a \ in a long string is a blank, with undefined behaviour beyond ASCII.
    std::optional<size_t> skip_string() {
        const char quote = text_[at_];
        const bool escapes = quote == '"';
        const std::string_view long_quote = escapes ? "\"\"\"" : "'''";
        const bool is_long = text_.substr(at_, 3) == long_quote;
        at_ += is_long ? 3 : 1;
        for (; at_ < text_.size(); ++at_) {
            const char c = text_[at_];
            if (escapes && c == '\\') {
                ++at_;
                if (!is_long) continue;
                const size_t next = text_.find_first_not_of(" \t\r\n", at_);
                if (next != std::string_view::npos && !is_ascii(text_[next])) return next;
            } else if (c == '\n' && !is_long) {
                return {};
            } else if (c == quote && !is_long) {
                ++at_;
                return {};
            } else if (c == quote && text_.substr(at_, 3) == long_quote) {
                at_ += 3;
                // Up to two quotes may stand before the closing ones.
                for (int i = 0; i < 2 && at_ < text_.size() && text_[at_] == quote; ++i) ++at_;
                return {};
            }
        }
        at_ = text_.size();
        return {};
    }

    std::string_view text_;
    size_t at_ = 0;
    bool is_value_ = false;   ///< what stands here is a part of a value, not of a key
    std::vector<char> open_;  ///< arrays and tables that a value has begun
};

SourcePosition position_in(const std::string& text, size_t at) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
    const size_t line_begin = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
    return {static_cast<int>(std::count(text.begin(), end, '\n')) + 1,
            static_cast<int>(at - (line_begin == std::string::npos ? 0 : line_begin + 1)) + 1};
}

}  // namespace

Result<toml::table> parse_toml(const std::string& text, const std::string& path) {
    if (text.size() > kTomlCapacity) {
        return Error{fmt::format("{}: must be at most {} MiB", path, kTomlCapacity >> 20)};
    }
    if (const auto fault = KeyScanner(text).find_fault()) {
        return Error{error_text({{position_in(text, fault->at), fault->text}}, path)};
    }
    toml::parse_result parsed = toml::parse(text, path);
    // Moved, because a copy of a table forgets where its values stand.
    if (parsed) return std::move(parsed).table();
    const toml::source_position at = parsed.error().source().begin;
    return Error{error_text({{{static_cast<int>(at.line), static_cast<int>(at.column)},
                              std::string(parsed.error().description())}},
                            path)};
}

Result<toml::table> read_toml(const std::string& path) {
    const auto text = read_file(path, kTomlCapacity);
    if (!text) return Error{text.error()};
    return parse_toml(*text, path);
}

}  // namespace bsoil::scene
