/// The tags of an XML text one by one, for what has to be known before a parser gets it.
#pragma once

#include <string>
#include <string_view>

namespace bsoil::scene {

/// Comments, CDATA and declarations are skipped; so is what stands in quotes inside a tag. Bad
/// syntax is the parser's to refuse.
class XmlTagReader {
  public:
    explicit XmlTagReader(std::string_view text) : text_(text) {}

    struct Tag {
        std::string_view text;               ///< from behind '<' to before '>'
        bool opens = false, closes = false;  ///< both: <name/>
        size_t begin = 0, end = 0;           ///< in the text: of '<', and behind '>'
    };

    /// False at the end.
    bool next(Tag& tag);
    /// Whether a declaration so far, <?...?> or <!...>, ends where parsers do not agree. What is
    /// behind it may not be what they take it for.
    bool has_odd_declaration() const { return has_odd_declaration_; }

  private:
    void skip_behind(std::string_view end, size_t from);
    void skip_declaration(std::string_view rest);

    std::string_view text_;
    size_t at_ = 0;
    bool has_odd_declaration_ = false;
};

/// Whether a tag's text is that of an element, which it opens.
bool is_element(std::string_view tag, std::string_view name);

/// The value of an attribute of a tag; empty where it has none.
std::string attribute(std::string_view tag, std::string_view name);

}  // namespace bsoil::scene
