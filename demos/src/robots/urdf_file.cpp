#include "urdf_file.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cctype>
#include <map>
#include <mutex>
#include <set>
#include <string_view>

#include "files/text_file.h"
#include "files/xml_check.h"
#include "files/xml_tags.h"

namespace bsoil::scene {
namespace {

constexpr size_t kLinkCapacity = 1000;
constexpr size_t kUrdfCapacity = 16 << 20;  // [bytes]

/// Collects what urdfdom says instead of printing it.
class Messages final : public console_bridge::OutputHandler {
  public:
    Messages() { console_bridge::useOutputHandler(this); }
    ~Messages() override { console_bridge::restorePreviousOutputHandler(); }
    Messages(const Messages&) = delete;
    Messages& operator=(const Messages&) = delete;
    void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
        if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) {
            errors += (errors.empty() ? "" : "; ") + text;
        }
    }
    std::string errors;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& xml, std::string& errors) {
    static std::mutex only_one;  // console_bridge has one handler for all threads
    const std::lock_guard lock(only_one);
    Messages messages;
    urdf::ModelInterfaceSharedPtr model;
    try {
        model = urdf::parseURDF(xml);
    } catch (const std::exception& thrown) {
        messages.errors += (messages.errors.empty() ? "" : "; ") + std::string(thrown.what());
    }
    errors = messages.errors;
    return model;
}

/// An expanded file may still name xacro, in comments and as a namespace, but has no element of it.
bool is_xacro(const std::string& xml) {
    XmlTagReader tags(xml);
    for (XmlTagReader::Tag tag; tags.next(tag);) {
        if (tag.text.starts_with("xacro:")) return true;
    }
    return false;
}

/// Leaves out each <material> of the robot's own whose name an earlier one has. urdfdom refuses the
/// file for it; Bullet and ROS load it, and it only concerns colours.
std::string without_repeated_materials(const std::string& xml) {
    std::set<std::string> known;
    std::string out;
    size_t copied = 0, drop_from = std::string::npos;
    int depth = 0;  // of the tag's parent: the robot's own elements lie at 1
    XmlTagReader tags(xml);
    for (XmlTagReader::Tag tag; tags.next(tag);) {
        if (!tag.opens) --depth;
        if (depth == 1 && tag.opens && is_element(tag.text, "material") &&
            !known.insert(attribute(tag.text, "name")).second) {
            drop_from = tag.begin;
        }
        if (depth == 1 && tag.closes && drop_from != std::string::npos) {
            out.append(xml, copied, drop_from - copied);
            copied = tag.end;
            drop_from = std::string::npos;
        }
        if (!tag.closes) ++depth;
    }
    return out.append(xml, copied);
}

/// xacro's `$(optenv NAME DEFAULT)` replaced by DEFAULT, once from left to right.
std::string with_defaults(const std::string& text) {
    constexpr std::string_view kBegin = "$(optenv";
    const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
    const auto is_name = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    };
    std::string out;
    size_t copied = 0;
    for (size_t begin = text.find(kBegin); begin != std::string::npos;
         begin = text.find(kBegin, begin + 1)) {
        if (begin < copied) continue;  // inside the default of the one before
        size_t at = begin + kBegin.size();
        const auto skip = [&](const auto& is_one) {
            const size_t from = at;
            while (at < text.size() && is_one(text[at])) ++at;
            return at > from;
        };
        if (!skip(is_space) || !skip(is_name) || !skip(is_space)) continue;
        const size_t end = text.find(')', at);
        if (end == std::string::npos) break;
        out.append(text, copied, begin - copied).append(text, at, end - at);
        copied = end + 1;
    }
    return out.append(text, copied);
}

size_t reachable_count(const urdf::Link& link) {
    size_t count = 1;
    for (const auto& child : link.child_links) count += reachable_count(*child);
    return count;
}

/// The links of a loop hold each other and would never be freed.
void untie(urdf::ModelInterface& model) {
    for (const auto& [name, link] : model.links_) link->child_links.clear();
}

/// urdfdom takes a link with two parents, and then has its solids twice.
Status check_tree(const urdf::ModelInterface& model, const std::string& path) {
    if (model.links_.size() > kLinkCapacity) {
        return Error{fmt::format("{}: has {} links, must have at most {}", path,
                                 model.links_.size(), kLinkCapacity)};
    }
    std::map<std::string, std::string> joint_of;
    for (const auto& [name, joint] : model.joints_) {
        const auto [first, is_first] = joint_of.emplace(joint->child_link_name, name);
        if (!is_first) {
            return Error{
                fmt::format("{}: link \"{}\" is the child of the joints \"{}\" and "
                            "\"{}\": links and joints have to form a tree",
                            path, joint->child_link_name, first->second, name)};
        }
    }
    const size_t reached = reachable_count(*model.getRoot());
    if (reached != model.links_.size()) {
        return Error{fmt::format(
            "{}: {} of {} links do not hang on the root \"{}\": their joints "
            "form a loop; cut it",
            path, model.links_.size() - reached, model.links_.size(), model.getRoot()->name)};
    }
    return Done{};
}

}  // namespace

Result<urdf::ModelInterfaceSharedPtr> read_urdf(const std::string& path) {
    const auto text = read_file(path, kUrdfCapacity);
    if (!text) return Error{text.error()};
    if (is_xacro(*text)) {
        return Error{
            fmt::format("{}: is a xacro file, which must be expanded into a URDF first: xacro {} "
                        "> robot.urdf (xacro comes with ROS; pip install xacro has it too)",
                        path, path)};
    }
    std::string xml = with_defaults(*text);
    if (const Status flat = check_xml_depth(xml); !flat) {
        return Error{fmt::format("{}: not a valid URDF: {}", path, flat.error())};
    }
    xml = without_repeated_materials(xml);
    std::string errors;
    urdf::ModelInterfaceSharedPtr model = parse(xml, errors);
    if (!model || !model->getRoot()) {
        return Error{fmt::format("{}: not a valid URDF: {}", path,
                                 errors.empty() ? "it must have a root link" : errors)};
    }
    // A faulty inertial or collision is reported and left out: it would be missed.
    if (!errors.empty()) return Error{fmt::format("{}: {}", path, errors)};
    const Status is_tree = check_tree(*model, path);
    if (!is_tree) {
        untie(*model);
        return Error{is_tree.error()};
    }
    return model;
}

}  // namespace bsoil::scene
