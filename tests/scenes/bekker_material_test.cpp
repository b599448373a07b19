/// Materials given by Bekker's parameters in scene files.
#include <gtest/gtest.h>

#include "bsoil/contact/bekker_soil.h"
#include "reading/scene_load.h"

namespace bsoil::scene::bekker_material_test {
namespace {

/// A scene whose soil is of a material with these keys, which stand from line 7 on.
Result<Scene> scene_with(const std::string& keys) {
    return parse_scene(
        "[world]\nduration_s = 1.0\n[soil]\nsize_m = [1, 1, 1]\nmaterial = \"loam\"\n"
        "[[material]]\nname = \"loam\"\n" +
            keys,
        "s.toml");
}

void expect_error(const std::string& keys, const std::string& expected) {
    const auto scene = scene_with(keys);
    const std::string errors = scene ? "no error" : scene.error();
    EXPECT_NE(errors.find(expected), std::string::npos)
        << "expected: " << expected << "\nfound:    " << errors;
}

const std::string kStrength = "cohesion_pa = 3700\nfriction_angle_deg = 29.8\n";  // lines 8 and 9

TEST(BekkerMaterial, is_the_translated_material) {
    const auto scene = scene_with(
        kStrength +
        "shear_displacement_m = 0.01\ntool_friction = 0.3\nbekker = { kphi = 752e3, kc = 6900, n "
        "= 0.66 }\n");
    ASSERT_TRUE(scene) << scene.error();
    BekkerSoil soil;
    soil.kphi_pa_m_n = 752e3;
    soil.kc_pa_m_n1 = 6900;
    soil.n = 0.66;
    soil.cohesion_pa = 3700;
    soil.friction_angle_rad = 29.8 * 3.14159265358979323846 / 180;
    soil.shear_displacement_m = 0.01;
    const auto found = translate(soil);
    ASSERT_TRUE(found) << found.error();
    const MaterialDef& m = scene->soil->def.materials.at(0);
    EXPECT_EQ(m.density_kg_m3, found->material.density_kg_m3);
    EXPECT_EQ(m.loose_density_kg_m3, found->material.loose_density_kg_m3);
    EXPECT_EQ(m.compacted_density_kg_m3, found->material.compacted_density_kg_m3);
    EXPECT_EQ(m.cohesion_pa, 3700);
    EXPECT_EQ(m.friction_angle_rad, soil.friction_angle_rad);
    EXPECT_EQ(m.shear_displacement_m, 0.01);
    EXPECT_EQ(m.tool_friction, 0.3);
}

TEST(BekkerMaterial, keeps_a_density_that_is_given) {
    const auto scene =
        scene_with(kStrength + "density_kg_m3 = 1500\nbekker = { kphi = 752e3, n = 0.66 }\n");
    ASSERT_TRUE(scene) << scene.error();
    EXPECT_EQ(scene->soil->def.materials.at(0).density_kg_m3, 1500);
}

TEST(BekkerMaterial, warns_of_the_error_of_its_translation) {
    const auto scene = scene_with(kStrength + "bekker = { kphi = 752e3, kc = 6900, n = 0.66 }\n");
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->warnings.size(), 1u);
    const std::string& warning = scene->warnings[0];
    EXPECT_TRUE(warning.starts_with("s.toml:10:10: the bearing of \"loam\" differs from Bekker's"))
        << warning;
    EXPECT_NE(warning.find("% (median; at most "), std::string::npos) << warning;
    EXPECT_EQ(warning.find('\n'), std::string::npos);
}

TEST(BekkerMaterial, other_materials_warn_of_nothing) {
    const auto scene = scene_with(kStrength);
    ASSERT_TRUE(scene) << scene.error();
    EXPECT_TRUE(scene->warnings.empty());
}

TEST(BekkerMaterial, needs_strength_in_shear) {
    expect_error("friction_angle_deg = 29.8\nbekker = { kphi = 752e3, n = 0.66 }\n",
                 "s.toml:9:10: `bekker` needs `cohesion_pa`");
    expect_error("cohesion_pa = 0\nbekker = { kphi = 752e3, n = 0.66 }\n",
                 "s.toml:9:10: `bekker` needs `friction_angle_deg`");
}

TEST(BekkerMaterial, mistakes_are_reported_with_their_place) {
    expect_error(kStrength + "bekker = 752e3\n", "s.toml:10:10: `bekker`: expected a table");
    expect_error(kStrength + "bekker = { kphi = 752e3 }\n", "[material.bekker] needs `n`");
    expect_error(kStrength + "bekker = { kphi = -1, n = 1 }\n",
                 "s.toml:10:19: `kphi`: -1 is out of range 0 .. 1000000000");
    expect_error(kStrength + "bekker = { kphi = nan, n = 1 }\n", "`kphi`: nan is out of range");
    expect_error(kStrength + "bekker = { kphi = 1e6, n = 2.6 }\n",
                 "`n`: 2.6 is out of range 0 .. 2.5");
    expect_error(kStrength + "bekker = { kphi = 1e6, n = 1, damping = 3e4 }\n",
                 "unknown key `damping` in [material.bekker]");
    expect_error(kStrength + "bekker = { kphi = 0, n = 1 }\n",
                 "s.toml:10:10: `bekker`: kphi and kc are 0: one of them must be positive");
    expect_error(kStrength + "bekker = { kphi = 1e6, kc = -1e6, n = 1 }\n",
                 "`bekker`: kc is -1e+06, must exceed -25000");
    expect_error(kStrength + "loose_density_kg_m3 = 1300\nbekker = { kphi = 1e6, n = 1 }\n",
                 "s.toml:10:23: `loose_density_kg_m3` is what `bekker` is turned into");
}

TEST(ContactLawKey, names_each_law_that_needs_no_parameters) {
    for (const auto& [name, kind] : {std::pair{"granular", ContactLawDef::Kind::granular},
                                     {"plain", ContactLawDef::Kind::plain},
                                     {"work", ContactLawDef::Kind::work}}) {
        const auto scene = parse_scene(
            std::string("[world]\nduration_s = 1.0\n[soil]\nsize_m = [1, 1, 1]\ncontact_law = \"") +
                name + "\"\n",
            "s.toml");
        ASSERT_TRUE(scene) << scene.error();
        EXPECT_EQ(scene->soil->def.contact_law.kind, kind) << name;
    }
}

TEST(BekkerMaterial, gives_its_parameters_to_a_law_that_wants_them) {
    const auto text = [](const std::string& material, const std::string& bekker) {
        return "[world]\nduration_s = 1.0\n[soil]\nsize_m = [1, 1, 1]\ncontact_law = \"bekker\"\n"
               "material = \"" +
               material + "\"\n[[material]]\nname = \"loam\"\n" + kStrength + bekker;
    };
    const std::string bekker = "bekker = { kphi = 752e3, kc = 6900, n = 0.66 }\n";
    const auto scene = parse_scene(text("loam", bekker), "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    const ContactLawDef& law = scene->soil->def.contact_law;
    EXPECT_EQ(law.kind, ContactLawDef::Kind::bekker);
    ASSERT_EQ(law.bekker.size(), 1u);
    EXPECT_EQ(law.bekker[0].n, 0.66);
    EXPECT_EQ(law.bekker[0].cohesion_pa, 3700);
    for (const auto& [material, keys] :
         {std::pair{"loam", std::string()}, std::pair{"clay", bekker}}) {
        const auto refused = parse_scene(text(material, keys), "s.toml");
        ASSERT_FALSE(refused);
        EXPECT_NE(refused.error().find("s.toml:5:1"), std::string::npos) << refused.error();
        EXPECT_NE(refused.error().find("needs [material.bekker] of"), std::string::npos);
    }
}

}  // namespace
}  // namespace bsoil::scene::bekker_material_test
