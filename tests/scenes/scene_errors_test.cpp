/// Mistakes in scene files: each is reported with its place and the way out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cure.h"
#include "reading/scene_load.h"

namespace bsoil::scene::scene_errors_test {
namespace {

const std::string kWorld = "[world]\nduration_s = 1.0\n";  // lines 1 and 2

std::string errors_of(const std::string& text) {
    const auto scene = parse_scene(text, "s.toml");
    return scene ? "no error" : scene.error();
}

/// The scene is the world above with `more` from line 3 on.
void expect_error(const std::string& more, const std::string& expected) {
    const std::string errors = errors_of(kWorld + more);
    EXPECT_NE(errors.find(expected), std::string::npos)
        << "expected: " << expected << "\nfound:    " << errors;
    EXPECT_TRUE(says_what_to_do(errors)) << errors;
}

TEST(SceneErrors, smallest_scene_is_valid) { EXPECT_EQ(errors_of(kWorld), "no error"); }

TEST(SceneErrors, syntax_error_has_line_and_column) {
    // In toml++'s own words, which say what is wrong and no more.
    EXPECT_NE(errors_of(kWorld + "[soil\n").find("s.toml:3:6: "), std::string::npos);
    EXPECT_NE(errors_of(kWorld + "[soil]\nvoxel_m = 0.1\nvoxel_m = 0.2\n").find("s.toml:5:"),
              std::string::npos);
}

// toml++ reads on to the end of such a number, whatever is in it.
TEST(SceneErrors, quote_behind_a_number_is_no_string) {
    for (const std::string value : {"1.'x'", "[1.'''", "[[2], {a = 3, b.\"c\" = [4.\"d\""}) {
        EXPECT_NE(errors_of(kWorld + "x = " + value).find("a quote stands inside of a word"),
                  std::string::npos)
            << value;
    }
    for (const std::string value : {"1.[\"\"", "2{a = 1}", "3=4", "[5, 6[7]]"}) {
        EXPECT_NE(errors_of(kWorld + "x = " + value).find("` stands inside of a word"),
                  std::string::npos)
            << value;
    }
    // Parts of keys may have quotes, in tables inside of values as well.
    for (const std::string keys :
         {"a.\"b c\" = 1", "a = {b.\"c\" = 1, d.\"e\" = [1, 2], f.'g' = 3}", "[a.\"b\".c]",
          "a = [{b.\"c\" = 1}, {d.\"e\" = 2}]\nf.\"g\" = 1"}) {
        EXPECT_EQ(errors_of(kWorld + keys).find("quote"), std::string::npos) << keys;
    }
}

TEST(SceneErrors, unknown_key_suggests_the_nearest) {
    expect_error("gravty_m_s2 = 9.81\n",
                 "s.toml:3:1: unknown key `gravty_m_s2` in [world]; did you mean `gravity_m_s2`?");
    expect_error("[[boddy]]\n", "s.toml:3:3: unknown key `boddy` in a scene; did you mean `body`?");
}

TEST(SceneErrors, key_far_from_all_others_lists_them) {
    expect_error("[record]\ntemperature = 3\n", "the keys are bodies, every_s, moments_s");
}

TEST(SceneErrors, wrong_unit_names_the_key_and_converts) {
    expect_error(
        "[[material]]\nname = \"clay\"\n  cohesion_kpa = 1.5\n",
        "s.toml:5:3: wrong unit in `cohesion_kpa`: the key is `cohesion_pa`: cohesion_pa = 1500");
    expect_error("[soil]\nsize_m = [1, 1, 1]\nvoxel_cm = 5\n", "voxel_m = 0.05");
    expect_error("[soil]\nsize_m = [1, 1, 1]\nyaw_rad = 0.5\n", "yaw_deg = 28.6");
    expect_error("[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass = 3\n",
                 "s.toml:7:1: wrong unit in `mass`: the key is `mass_kg`");
}

TEST(SceneErrors, wrong_type_says_what_is_there) {
    expect_error("gravity_m_s2 = \"strong\"\n",
                 "s.toml:3:16: `gravity_m_s2`: expected a number, not the text \"strong\"");
    expect_error("[soil]\nsize_m = 3\n", "`size_m`: expected a list of numbers, not the integer 3");
    expect_error("[soil]\nsize_m = [1, 2]\n", "`size_m`: expected 3 numbers, not 2");
    expect_error("solver_iterations = 2.5\n", "expected an integer, not the number 2.5");
    expect_error("ground_plane = 1\n", "expected true or false, not the integer 1");
    expect_error("[body]\nname = \"a\"\n", "`body` is written once for each: [[body]], not [body]");
}

TEST(SceneErrors, number_out_of_range_gives_the_range) {
    expect_error("[soil]\nsize_m = [1, 1, 1]\nvoxel_m = 50\n",
                 "s.toml:5:11: `voxel_m`: 50 is out of range 0.001 .. 1");
    expect_error("gravity_m_s2 = nan\n", "out of range");
    expect_error("gravity_m_s2 = inf\n", "out of range");
}

TEST(SceneErrors, missing_key_names_it) {
    EXPECT_NE(errors_of("[world]\n").find("s.toml:1:1: [world] needs `duration_s`"),
              std::string::npos);
    EXPECT_NE(errors_of("title = \"x\"\n").find("a scene needs [world]: "), std::string::npos);
    expect_error("[[body]]\nname = \"a\"\nshape = \"sphere\"\n",
                 "s.toml:3:1: [body] needs `radius_m`");
}

TEST(SceneErrors, key_of_another_kind_is_refused) {
    expect_error("[[body]]\nname = \"a\"\nshape = \"sphere\"\nradius_m = 1\nsize_m = [1, 1, 1]\n",
                 "s.toml:7:1: `size_m` has no meaning with shape = \"sphere\"");
    expect_error("[[body]]\nname = \"a\"\nshape = \"pyramid\"\n",
                 "\"pyramid\" is not one of box, sphere");
}

TEST(SceneErrors, all_mistakes_are_reported_in_the_order_of_the_file) {
    const std::string errors = errors_of(kWorld + "up = \"x\"\ngravity_m_s2 = 99\n");
    EXPECT_LT(errors.find("s.toml:3:6"), errors.find("s.toml:4:16"));
}

TEST(SceneErrors, material_has_to_be_defined) {
    expect_error("[soil]\nsize_m = [1, 1, 1]\nmaterial = \"snow\"\n",
                 "s.toml:5:12: no [[material]] is named \"snow\", and no built-in");
    expect_error(
        "[soil]\nsize_m = [1, 1, 1]\n[[fill]]\nkind = \"box\"\nmin_m = [0, 0, 0]\nmax_m = [1, 1, "
        "1]\n"
        "material = \"clay\"\n",
        "s.toml:9:12: \"clay\" is none of the soil's materials");
    expect_error(
        "[soil]\nsize_m = [1, 1, 1]\n[[probe]]\nname = \"p\"\nkind = \"mass_inside\"\n"
        "size_m = [1, 1, 1]\nmaterial = \"clay\"\n",
        "s.toml:9:12: \"clay\" is none of the soil's materials");
}

const std::string kBox =
    "[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [1, 1, 1]\n";  // lines 3 to 6

const std::string kSoil = "[soil]\nsize_m = [2, 1, 1]\n";  // two lines

TEST(SceneErrors, sources_sinks_and_open_sides_are_checked) {
    const std::string soil = "[soil]\nsize_m = [1, 1, 1]\n";
    expect_error(soil + "open_sides = [\"east\"]\n", "\"east\" is not one of -x, +x");
    expect_error(soil + "open_sides = 3\n", "expected a list of texts, not the integer 3");
    expect_error("[[source]]\nshape = \"disc\"\ncenter_m = [0, 0, 1]\n",
                 "[source] needs `radius_m`");
    expect_error("[[source]]\nshape = \"cone\"\n", "\"cone\" is not one of disc, rectangle");
    expect_error("[[source]]\nshape = \"disc\"\nrate_kg_s = -1\n", "-1 is out of range");
    expect_error("[[sink]]\nshape = \"box\"\nposition_m = [0, 0, 0]\n", "[sink] needs `size_m`");
    expect_error("[[sink]]\nshape = \"sphere\"\nrate_kg_s = nan\n", "out of range");
}

TEST(SceneErrors, body_names_are_unique) {
    expect_error(kBox + kBox, "s.toml:8:8: a [[body]] named \"a\" stands in line 4 already");
}

TEST(SceneErrors, body_has_to_be_defined) {
    expect_error(kBox +
                     "[[joint]]\nname = \"j\"\nkind = \"fixed\"\nparent = \"a\"\nchild = "
                     "\"b\"\npoint_m = [0, 0, 0]\n",
                 "s.toml:11:9: no [[body]] is named \"b\"");
    expect_error("[[check]]\nkind = \"body_at_rest\"\nbody = \"b\"\nby_s = 0.5\n",
                 "s.toml:5:8: no [[body]]");
}

TEST(SceneErrors, track_needs_wheels_and_links_that_fit) {
    const std::string hull =  // lines 3 to 7
        "[[body]]\nname = \"hull\"\nshape = \"box\"\nsize_m = [2, 1, 0.5]\nmass_kg = 500\n";
    const auto track = [&](const std::string& keys, const std::string& wheels) {
        return hull + "[[track]]\nname = \"t\"\nhull = \"hull\"\n" + keys + "\nwheel = [\n" +
               wheels + "]\n";  // keys in line 11, wheels from line 13 on
    };
    const std::string front =
        "{ name = \"front\", position_m = [1, 1, 0], radius_m = 0.2, width_m = 0.2 },\n";
    const std::string rear =
        "{ name = \"rear\", position_m = [-1, 1, 0], radius_m = 0.2, width_m = 0.2 },\n";
    EXPECT_EQ(errors_of(kWorld + track("link_count = 40", front + rear)), "no error");
    EXPECT_EQ(errors_of(kWorld + track("pitch_m = 0.13", front + rear)), "no error");
    expect_error(track("link_count = 40", front), "s.toml:8:1: a track needs at least two");
    expect_error(track("link_count = 40", front + front),
                 "s.toml:14:10: a [[track.wheel]] named \"front\" stands in line 13 already");
    expect_error(
        track("link_count = 40",
              front + "{ name = \"b\", position_m = [0.7, 1, 0], radius_m = 0.15, width_m = "
                      "0.2 },\n"),
        "wheels \"front\" and \"b\" overlap: 0.3 m apart, radii 0.2 m and 0.15 m");
    expect_error(
        track("link_count = 40",
              front + "{ name = \"b\", position_m = [-1, 0.9, 0], radius_m = 0.2, width_m = "
                      "0.2 },\n"),
        "wheel \"b\" stands 0.1 m beside the plane of wheel \"front\"");
    expect_error(track("", front + rear), "give `link_count` or `pitch_m`");
    expect_error(track("link_count = 40\npitch_m = 0.1", front + rear),
                 "give `link_count` or `pitch_m`");
    expect_error(track("link_count = 2", front + rear), "2 links do not go round anything");
    expect_error(track("link_count = 12", front + rear),
                 "do not bend round wheel \"rear\" of radius 0.2 m");
    expect_error(track("pitch_m = 0.001", front + rear), "3 .. 1000");
    expect_error(track("link_count = 40\nlink_width_m = 0.21", front + rear),
                 "no room for guides beside wheels of 0.2 m: `link_width_m` at least 0.2381");
    expect_error(
        track("link_count = 40\ngrouser_height_m = 0.1\ngrouser_thickness_m = 0.3", front + rear),
        "grousers of 0.3 m are thicker than links");
    expect_error(track("link_count = 40\naxis = [0, 0, 0]", front + rear), "must have a length");
    expect_error(track("link_count = 40",
                       front + "{ name = \"b\", position_m = [-1, 1, 0], radius_m = 0.2, width_m = "
                               "0.2, max_velocity_deg_s = 90 },\n"),
                 "wheel \"b\" has no motor");
    expect_error("[[track]]\nname = \"t\"\nhull = \"hul\"\n", "no [[body]] is named \"hul\"");
}

TEST(SceneErrors, file_has_to_be_there) {
    expect_error("[soil]\nsize_m = [1, 1, 1]\n[[terrain]]\nkind = \"mesh\"\nfile = \"rock.obj\"\n",
                 "s.toml:7:8: there is no file \"rock.obj\" beside the scene");
}

TEST(SceneErrors, absent_data_is_noted_and_no_error) {
    const auto scene = parse_scene(
        kWorld +
            "[[robot]]\nname = \"r\"\nfile = \"data:no/such.urdf\"\n"
            "[[motion]]\njoint = \"r/wheel\"\nkey = [{ t_s = 0, velocity_deg_s = 1 }]\n",
        "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    EXPECT_EQ(scene.value().missing_data, std::vector<std::string>{"data:no/such.urdf"});
}

TEST(SceneErrors, motion_drives_what_has_a_motor) {
    const std::string joint =
        "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"a\"\npoint_m = "
        "[0, 0, 0]\n";
    expect_error(
        kBox + joint + "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, position_deg = 0 }]\n",
        "s.toml:14:9: joint \"j\" has no motor");
    expect_error(
        kBox + joint +
            "motor_torque_n_m = 1\n[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, offset_m = 0 }]\n",
        "joint \"j\" is a hinge: give `position_deg` or `velocity_deg_s`");
    expect_error(kBox + "[[motion]]\nbody = \"a\"\nkey = [{ t_s = 0, position_m = [0, 0, 0] }]\n",
                 "s.toml:8:8: \"a\" is not kinematic");
    expect_error(kBox + joint +
                     "motor_torque_n_m = 1\n[[motion]]\njoint = \"j\"\n"
                     "key = [{ t_s = 1, position_deg = 0 }, { t_s = 1, position_deg = 1 }]\n",
                 "`t_s` must rise");
}

TEST(SceneErrors, substep_has_to_divide_the_soils_step) {
    expect_error("substep_s = 0.007\n[soil]\nsize_m = [1, 1, 1]\n",
                 "s.toml:3:13: `substep_s` 0.007 must divide the soil's `step_s`");
}

TEST(SceneErrors, check_after_the_end_of_the_run_is_refused) {
    expect_error(kBox + "[[check]]\nkind = \"body_at_rest\"\nbody = \"a\"\nby_s = 5\n",
                 "s.toml:10:8: `by_s` 5 lies after the end of the run, 1 s");
}

TEST(SceneErrors, window_of_a_check_has_a_length) {
    expect_error(kBox + "[[check]]\nkind = \"body_rise\"\nbody = \"a\"\nfrom_s = 0.5\nto_s = 0.5\n",
                 "s.toml:11:8: `to_s` 0.5 must lie after `from_s` 0.5");
    expect_error(kBox + "[[check]]\nkind = \"speed_steady\"\nbody = \"a\"\nto_s = 5\n",
                 "s.toml:10:8: `to_s` 5 lies after the end of the run, 1 s");
}

TEST(SceneErrors, moment_after_the_end_of_the_run_is_refused) {
    expect_error("[record]\nmoments_s = [0.5, 7]\n",
                 "s.toml:4:13: `moments_s` 7 lies after the end of the run, 1 s; raise");
}

TEST(SceneErrors, unsteadiness_needs_three_steps) {
    const std::string steady = kSoil + kBox + "[[check]]\nbody = \"a\"\nkind = ";
    expect_error(steady + "\"force_steady\"\nfrom_s = 0.999\nmax_deviation_fraction = 0.1\n",
                 "`from_s` 0.999 until 1 s there are 1 steps, and unsteadiness needs at least 3");
    expect_error(steady + "\"speed_steady\"\nfrom_s = 0.5\nto_s = 0.51\nmax_range_fraction = 1\n",
                 "raise `to_s`");
    expect_error(steady + "\"force_steady\"\nto_s = 0.034\nmax_range_fraction = 1\n",
                 "there are 2 steps");  // at the start there is no force yet
    EXPECT_EQ(
        errors_of(kWorld + steady + "\"speed_steady\"\nto_s = 0.034\nmax_range_fraction = 1\n"),
        "no error");
    EXPECT_EQ(errors_of(kWorld + steady + "\"force_steady\"\nfrom_s = 0.999\nmax_n = 1\n"),
              "no error");
}

TEST(SceneErrors, limits_of_a_check_leave_something_between) {
    const std::string check = kSoil + kBox + "[[check]]\nkind = ";
    expect_error(check + "\"body_height\"\nbody = \"a\"\nmin_m = 2\nmax_m = 1\n",
                 "s.toml:13:9: `max_m` 1 must not be below `min_m` 2: no value lies between");
    expect_error(check + "\"body_force\"\nbody = \"a\"\nmin_n = 2\nmax_n = 1\n", "`max_n` 1");
    expect_error(check + "\"mass_in\"\nat_s = 1\nmin_kg = 2\nmax_kg = 1\n", "`max_kg` 1");
    expect_error(check + "\"speed_steady\"\nbody = \"a\"\nmin_m_s = 2\nmax_m_s = 1\n",
                 "`max_m_s` 1");
    EXPECT_EQ(errors_of(kWorld + check + "\"body_height\"\nbody = \"a\"\nmin_m = 1\nmax_m = 1\n"),
              "no error");
}

TEST(SceneErrors, heights_are_measured_inside_of_the_soils_box) {
    const auto at = [](const std::string& place, const std::string& more) {
        return kSoil + more + "[[check]]\nkind = \"surface_height\"\nat_s = 1\nexpected_m = 0\n" +
               "tolerance_m = 1\nat_m = " + place + '\n';
    };
    const std::string yaw = "yaw_deg = 45\n";
    expect_error(at("[5, 0, 0]", ""),
                 "s.toml:10:8: `at_m` [5, 0, 0] lies beside the soil, whose box of 2 x 1 m has its "
                 "middle at [0, 0, 0]; move it inside, or enlarge `size_m` of [soil]");
    expect_error(at("[0, 0.6, 0]", ""), "lies beside the soil");
    expect_error(at("[0.9, 0, 0]", yaw), "lies beside the soil");
    for (const std::string inside : {"[1, -0.5, 0]", "[-1, 0.5, 9]"}) {
        EXPECT_EQ(errors_of(kWorld + at(inside, "")), "no error") << inside;
    }
    EXPECT_EQ(errors_of(kWorld + at("[0.7, 0.7, 0]", yaw)), "no error");
    const std::string y_up = "up = \"y\"\n";
    EXPECT_EQ(errors_of(kWorld + y_up + at("[0.7, 0, -0.7]", yaw)), "no error");
    expect_error(y_up + at("[0.7, 0, 0.7]", yaw), "lies beside the soil");
    expect_error(kSoil +
                     "[[probe]]\nname = \"p\"\nkind = \"profile\"\nfrom_m = [0, 0, 0]\nto_m = "
                     "[0, 1, 0]\n",
                 "`to_m` [0, 1, 0] lies beside the soil");
    expect_error(kSoil +
                     "[[check]]\nkind = \"repose_angle\"\ncenter_m = [2, 0, 0]\nexpected_deg = "
                     "30\ntolerance_deg = 1\n",
                 "`center_m` [2, 0, 0] lies beside the soil");
}

TEST(SceneErrors, direction_of_a_check_has_a_length) {
    expect_error(kBox + "[[check]]\nkind = \"speed_steady\"\nbody = \"a\"\ndirection = [0, 0, 0]\n",
                 "s.toml:10:13: the direction must have a length");
}

TEST(SceneErrors, energy_is_that_of_bodies_with_mass) {
    const std::string check =
        "[[check]]\nkind = \"energy_not_rising\"\ntolerance_j = 0.1\nbodies = ";
    expect_error(kBox + check + "[\"b\"]\n", "s.toml:10:10: no [[body]] is named \"b\"");
    expect_error(kBox + check + "[\"a\"]\n", "s.toml:10:10: \"a\" has no mass and so no energy");
    expect_error("[[check]]\nkind = \"energy_not_rising\"\n",
                 "s.toml:3:1: [check] needs `tolerance_j`");
}

TEST(SceneErrors, force_on_a_body_needs_soil) {
    expect_error(kBox + "[[check]]\nkind = \"force_steady\"\nbody = \"a\"\n",
                 "s.toml:8:8: \"force_steady\" needs a [soil]");
}

TEST(SceneErrors, body_that_ignores_soil_has_no_surface_for_it) {
    expect_error(kBox + "ignore_soil = true\ntool_friction = 0.3\n",
                 "s.toml:7:15: \"a\" has a surface for soil that it does not meet");
}

TEST(SceneErrors, densities_of_a_material_rise) {
    expect_error(
        "[soil]\nsize_m = [1, 1, 1]\nmaterial = \"m\"\n"
        "[[material]]\nname = \"m\"\ndensity_kg_m3 = 1500\nloose_density_kg_m3 = 1600\n"
        "compacted_density_kg_m3 = 1800\n",
        "densities are 1600");
}

TEST(SceneErrors, integers_too_large_for_a_double_are_out_of_range_all_the_same) {
    expect_error("substep_s = 9007199254740993\n", "9007199254740992 is out of range");
    expect_error("gravity_m_s2 = -9223372036854775807\n", "is out of range");
    expect_error("[soil]\nsize_m = [9007199254740993, 1, 1]\n", "is out of range");
}

TEST(SceneErrors, rounds_need_a_period) {
    expect_error(
        "[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 1\n[[joint]]\nname "
        "= \"j\"\nkind = "
        "\"hinge\"\nparent = \"world\"\nchild = \"a\"\npoint_m = [0, 0, 0]\nmotor_torque_n_m = "
        "1\n[[motion]]\njoint = \"j\"\nrepeat_count = 2\nkey = [{ t_s = 0, position_deg = 1 }]\n",
        "keys that are repeated must have a `period_s`");
}

TEST(SceneErrors, some_part_of_a_body_that_can_move_has_a_mass) {
    const std::string body =
        "[[body]]\nname = \"a\"\nshape = \"compound\"\nmass_kg = 1\n[[body.part]]\nshape = "
        "\"box\"\nsize_m = [1, 1, 1]\nmass_kg = 0\n";
    expect_error(body, "no part of \"a\" has a mass");
    EXPECT_EQ(
        errors_of(kWorld + body + "[[body.part]]\nshape = \"sphere\"\nradius_m = 1\nmass_kg = 2\n"),
        "no error");
}

}  // namespace
}  // namespace bsoil::scene::scene_errors_test
