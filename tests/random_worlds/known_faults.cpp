#include "known_faults.h"

#include <algorithm>
#include <string_view>

namespace bsoil::random_worlds {
namespace {

struct KnownFault {
    std::string_view invariant;
    bool (*applies)(const WorldPlan& plan);
    const char* reason;
};

/// Entries go when the fault does.
constexpr KnownFault kKnownFaults[] = {
    {"sinkage", [](const WorldPlan&) { return true; },
     "bodies of a few voxels sink deeper than plates of their size"},
    {"soil sleeps", [](const WorldPlan&) { return true; },
     "a voxel of soil caught beside a body goes to and fro for good (docs/contact_law.md, Sleep)"},
    {"bodies sleep",
     [](const WorldPlan& plan) {
         return std::any_of(plan.bodies.begin(), plan.bodies.end(), [&plan](const BodyPlan& b) {
             return !b.dropped && b.kind == BodyPlan::Kind::moving &&
                    bound_m(b.shape) < 4 * plan.soils[static_cast<size_t>(b.soil)].def.voxel_m;
         });
     },
     "bodies of a few voxels rock and keep what lies beside them awake"},
};

}  // namespace

const char* known_fault(const WorldPlan& plan, const Failure& failure) {
    for (const KnownFault& fault : kKnownFaults) {
        if (fault.invariant == failure.invariant && fault.applies(plan)) return fault.reason;
    }
    return nullptr;
}

}  // namespace bsoil::random_worlds
