#include "xml_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "xml_tags.h"

namespace bsoil::scene {
namespace {

/// The nodes of a COLLADA file and what they hold.
class NodeCounter {
  public:
    void read(const std::string& collada) {
        XmlTagReader tags(collada);
        std::vector<size_t> open;
        for (XmlTagReader::Tag tag; tags.next(tag);) {
            if (tag.text.starts_with('/')) {
                if (is_element(tag.text.substr(1), "node") && !open.empty()) open.pop_back();
            } else if (is_element(tag.text, "node")) {
                if (!open.empty()) nodes_[open.back()].children.push_back(nodes_.size());
                // The importer takes a node by its id, its sid or its name.
                for (const char* key : {"id", "sid", "name"}) {
                    const std::string name = attribute(tag.text, key);
                    if (!name.empty()) named_[name].push_back(nodes_.size());
                }
                if (!tag.closes) open.push_back(nodes_.size());
                nodes_.emplace_back();
            } else if (is_element(tag.text, "instance_node") && !open.empty()) {
                const std::string url = attribute(tag.text, "url");
                if (url.size() > 1) nodes_[open.back()].instances.push_back(url.substr(1));
            }
        }
    }

    /// All nodes, the named ones as often as they are named; more than the capacity where a node is
    /// inside itself.
    int64_t count() {
        if (nodes_.size() > kXmlNodeCapacity) return kXmlNodeCapacity + 1;
        int64_t sum = 0;
        for (size_t n = 0; n < nodes_.size() && sum <= kXmlNodeCapacity; ++n) sum += size_of(n, 0);
        return sum;
    }

  private:
    struct Node {
        std::vector<size_t> children;
        std::vector<std::string> instances;
        int64_t size = 0;
        bool is_open = false;
    };

    int64_t size_of(size_t n, int depth) {
        Node& node = nodes_[n];
        if (node.size > 0) return node.size;
        if (node.is_open || depth > kXmlDepthCapacity) return kXmlNodeCapacity + 1;
        node.is_open = true;
        int64_t sum = 1;
        for (const size_t child : node.children) sum += size_of(child, depth + 1);
        for (const std::string& name : node.instances) {
            if (const auto found = named_.find(name); found != named_.end()) {
                int64_t largest = 0;
                for (size_t i = 0; i < found->second.size() && largest <= kXmlNodeCapacity; ++i) {
                    largest = std::max(largest, size_of(found->second[i], depth + 1));
                }
                sum += largest;
            }
        }
        node.is_open = false;
        return node.size = std::min<int64_t>(sum, kXmlNodeCapacity + 1);
    }

    std::vector<Node> nodes_;
    std::map<std::string, std::vector<size_t>> named_;
};

}  // namespace

Status check_xml_depth(const std::string& xml) {
    XmlTagReader tags(xml);
    int depth = 0;
    for (XmlTagReader::Tag tag; tags.next(tag);) {
        depth = std::max(0, depth + (tag.opens ? 1 : 0) - (tag.closes ? 1 : 0));
        if (depth > kXmlDepthCapacity) {
            return Error{fmt::format("elements must lie at most {} deep inside each other",
                                     kXmlDepthCapacity)};
        }
    }
    if (tags.has_odd_declaration()) {
        return Error{
            "a declaration, <?...?> or <!...>, holds a <, > or [ or a single quote; leave "
            "it out"};
    }
    return Done{};
}

Status check_node_instances(const std::string& collada) {
    NodeCounter nodes;
    nodes.read(collada);
    if (nodes.count() > kXmlNodeCapacity) {
        return Error{
            fmt::format("its <instance_node> elements stand for more than {} nodes, or "
                        "for themselves; write the nodes out",
                        kXmlNodeCapacity)};
    }
    return Done{};
}

}  // namespace bsoil::scene
