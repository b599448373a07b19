#include "bsoil/contact/patch_elements.h"

#include <algorithm>
#include <vector>

#include "bsoil/contact/contact_law.h"
#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

double limit_n(const PatchElement& element, Vec3 shift_m, Vec3 up, const ContactLawDef& law) {
    const double risen_m = dot(shift_m, up);
    const bool goes_in = dot(shift_m, element.normal) > 0;
    const double back_m = risen_m > 0 && goes_in ? 0 : risen_m * looks_down(element.normal, up);
    const double depth_m = std::max(0.0, element.depth_m - risen_m);
    const double held = unloaded_share(depth_m, std::max(0.0, element.retreat_m + back_m), law);
    return element.pushed_n * (depth_m / element.depth_m) * std::max(held, kDrawnBackShare);
}

}  // namespace

void limit_shares(std::span<const PatchElement> elements, Vec3 shift_m, Vec3 up,
                  const ContactLawDef& law, std::span<double> shares) {
    const bool has_moved = shift_m != Vec3{};
    std::ranges::fill(shares, has_moved ? 0.0 : 1.0);
    if (!has_moved) return;
    std::vector<double> found_n(shares.size());
    for (const PatchElement& element : elements) {
        const auto patch = static_cast<size_t>(element.patch);
        found_n[patch] += limit_n(element, {}, up, law);
        shares[patch] += limit_n(element, shift_m, up, law);
    }
    for (size_t i = 0; i < shares.size(); ++i) {
        shares[i] = found_n[i] > 0 ? std::max(shares[i] / found_n[i], kDrawnBackShare) : 1;
    }
}

}  // namespace bsoil
