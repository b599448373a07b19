#include "xml_tags.h"

#include <algorithm>

namespace bsoil::scene {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

}  // namespace

bool XmlTagReader::next(Tag& tag) {
    for (;;) {
        at_ = text_.find('<', at_);
        if (at_ == std::string_view::npos) return false;
        const std::string_view rest = text_.substr(at_);
        if (rest.starts_with("<!--")) {
            skip_behind("-->", 4);
        } else if (rest.starts_with("<![CDATA[")) {
            skip_behind("]]>", 9);
        } else if (rest.starts_with("<!") || rest.starts_with("<?")) {
            skip_declaration(rest);
        } else {
            break;
        }
    }
    tag.begin = at_++;
    tag.opens = at_ < text_.size() && text_[at_] != '/';
    char quote = 0;
    for (; at_ < text_.size(); ++at_) {
        const char c = text_[at_];
        if (quote) {
            if (c == quote) quote = 0;
        } else if (tag.opens && (c == '"' || c == '\'')) {
            quote = c;
        } else if (c == '>') {
            break;
        }
    }
    tag.text = text_.substr(tag.begin + 1, at_ - tag.begin - 1);
    tag.end = at_ < text_.size() ? at_ + 1 : at_;
    tag.closes = !tag.opens || tag.text.ends_with('/');
    return true;
}

void XmlTagReader::skip_behind(std::string_view end, size_t from) {
    const size_t found = text_.find(end, at_ + from);
    at_ = found == std::string_view::npos ? text_.size() : found + end.size();
}

// For one parser <?a > ?> ends at its first '>', for another behind the second. What stands in
// brackets or quotes of a <!DOCTYPE> is alike.
void XmlTagReader::skip_declaration(std::string_view rest) {
    const bool is_instruction = rest[1] == '?';
    const std::string_view text = rest.substr(2, rest.find(is_instruction ? "?>" : ">", 2) - 2);
    has_odd_declaration_ |= text.size() + 2 >= rest.size() ||
                            text.find_first_of("<>[") != std::string_view::npos ||
                            std::count(text.begin(), text.end(), '"') % 2 != 0 ||
                            std::count(text.begin(), text.end(), '\'') % 2 != 0;
    skip_behind(">", 2);
}

bool is_element(std::string_view tag, std::string_view name) {
    return tag.starts_with(name) && (tag.size() == name.size() || tag[name.size()] == '/' ||
                                     kSpace.find(tag[name.size()]) != std::string_view::npos);
}

std::string attribute(std::string_view tag, std::string_view name) {
    for (size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
        if (at == 0 || kSpace.find(tag[at - 1]) == std::string_view::npos) continue;
        size_t value = tag.find_first_not_of(kSpace, at + name.size());
        if (value == std::string_view::npos || tag[value] != '=') continue;
        value = tag.find_first_of("\"'", value);
        if (value == std::string_view::npos) return {};
        const size_t end = tag.find(tag[value], value + 1);
        if (end == std::string_view::npos) return {};
        return std::string(tag.substr(value + 1, end - value - 1));
    }
    return {};
}

}  // namespace bsoil::scene
