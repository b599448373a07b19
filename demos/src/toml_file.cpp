#include "toml_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include "text_file.h"

namespace bsoil::scene {
namespace {

/// Walks through a text as TOML reads it, as far as it takes to tell a key's dots from others, a
/// table's header from a list, and what is quoted. Where the syntax is wrong it may lose its way:
/// the parser stops there.
class KeyScanner {
  public:
    explicit KeyScanner(std::string_view text) : text_(text) {}

    struct Fault {
        size_t at = 0;
        std::string text;
    };

    /// The first place that the parser must not get to; none in most files.
    std::optional<Fault> find_fault() {
        int dots = 0, depth = 0;  // depth: brackets that are open in a value
        bool begins_line = true;
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // the mark of the byte order
        while (at_ < text_.size()) {
            const char c = text_[at_];
            const bool is_header = c == '[' && begins_line && depth == 0;
            begins_line = c == '\n' || (begins_line && (is_blank(c) || c == '\r'));
            if (!is_ascii(c))
                return Fault{at_, "only quotes and comments may hold characters beyond ASCII"};
            switch (c) {
                case '#':
                    at_ = std::min(text_.find('\n', at_), text_.size());
                    continue;
                case '"':
                case '\'':
                    if (const auto at = skip_string())
                        return Fault{*at, "behind a \\ this has to be written as \\uXXXX"};
                    continue;
                case '.':
                    if (++dots >= kKeyPartCapacity)
                        return Fault{at_, fmt::format("a key has more than {} parts with dots "
                                                      "between them",
                                                      kKeyPartCapacity)};
                    break;
                case '[':
                    if (is_header && !is_table_name())
                        return Fault{at_,
                                     "a table's name is made of letters, digits, - and _, or "
                                     "stands in quotes"};
                    [[fallthrough]];
                case '{':
                    if (!is_header) ++depth;
                    dots = 0;
                    break;
                case ']':
                case '}':
                    depth = std::max(0, depth - 1);
                    [[fallthrough]];
                // Whatever stands between two keys or values.
                case '=':
                case ',':
                case '\n':
                    dots = 0;
                    break;
                default:
                    if (is_date()) return Fault{at_, "a date is no value of this file; quote it"};
            }
            ++at_;
        }
        return {};
    }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t'; }
    /// Whether a date begins here. No key takes one, and toml++ takes it for granted that its time
    /// begins with a digit.
    bool is_date() const {
        constexpr std::string_view kForm = "0000-00-00";
        for (size_t i = 0; i < kForm.size(); ++i) {
            const char c = at_ + i < text_.size() ? text_[at_ + i] : ' ';
            if (kForm[i] == '-' ? c != '-' : c < '0' || c > '9') return false;
        }
        return true;
    }
    static bool is_ascii(char c) { return (c & 128) == 0; }

    /// Whether the header that begins here goes on as one may; toml++ takes it for granted. Leaves
    /// the place at the header's last '[', or where it does not.
    bool is_table_name() {
        const auto skip_blanks = [&](size_t at) {
            while (at < text_.size() && is_blank(text_[at])) ++at;
            return at;
        };
        size_t name = skip_blanks(at_ + 1);
        if (name < text_.size() && text_[name] == '[') {
            at_ = name;
            name = skip_blanks(name + 1);
        }
        if (name >= text_.size()) return true;
        const auto c = static_cast<unsigned char>(text_[name]);
        if (std::isalnum(c) || c > 127 ||
            std::string_view("-_\"']").find(text_[name]) != std::string_view::npos)
            return true;
        at_ = name;
        return false;
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
};

SourcePosition position_in(const std::string& text, size_t at) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(at);
    const size_t line_begin = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
    return {static_cast<int>(std::count(text.begin(), end, '\n')) + 1,
            static_cast<int>(at - (line_begin == std::string::npos ? 0 : line_begin + 1)) + 1};
}

}  // namespace

Result<toml::table> parse_toml(const std::string& text, const std::string& path) {
    if (text.size() > kTomlCapacity)
        return Error{fmt::format("{}: larger than {} MiB", path, kTomlCapacity >> 20)};
    if (const auto fault = KeyScanner(text).find_fault())
        return Error{error_text({{position_in(text, fault->at), fault->text}}, path)};
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
