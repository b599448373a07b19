// Every kind of world: hosts with callbacks, several soils and worlds, threads, time steps.
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <limits>
#include <thread>

#include "sand_bed.h"

namespace bsoil::bullet {
namespace {

const btVector3 kHalfBox(0.2f, 0.2f, 0.2f);
constexpr btScalar kMassKg = 50;
constexpr double kWeightN = 50 * kGravity_m_s2;
const btVector3 kAbove(0, btScalar(kBedTopM) + btScalar(0.21), 0);

// --- switching on and off

TEST(Enabling, off_freezes_the_soil_and_lets_bodies_fall) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    EXPECT_TRUE(soil->is_enabled());
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(5);
    ASSERT_FALSE(box.isActive());
    const uint64_t checksum = soil->soil().checksum();
    const long long steps = soil->step_count();
    soil->set_enabled(false);
    EXPECT_FALSE(soil->is_enabled());
    const double from_m = height_of(box);
    const double time_s = 0.25;
    scene.run(time_s + 1.0 / 60);  // it is woken at the end of the first step
    EXPECT_NEAR(from_m - height_of(box), kGravity_m_s2 * time_s * time_s / 2,
                kGravity_m_s2 * time_s * (1.0 / 60));
    EXPECT_EQ(soil->soil().checksum(), checksum);
    EXPECT_EQ(soil->step_count(), steps);
    EXPECT_EQ(soil->body_report(box).patch_count, 0);
    EXPECT_TRUE(soil->last_report().contacts.empty());
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
}

TEST(Enabling, off_and_on_between_two_steps_changes_nothing) {
    uint64_t checksums[2];
    btScalar heights[2];
    for (const bool toggles : {false, true}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
        for (int frame = 0; frame < 60; ++frame) {
            if (toggles) {
                soil->set_enabled(false);
                soil->set_enabled(true);
            }
            scene.run(1.0 / 60);
        }
        checksums[toggles] = soil->soil().checksum();
        heights[toggles] = box.getWorldTransform().getOrigin().y();
    }
    EXPECT_EQ(checksums[0], checksums[1]);
    EXPECT_EQ(heights[0], heights[1]);
}

TEST(Enabling, on_again_goes_on_without_a_jump) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const int64_t before = units_of(*soil);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    btRigidBody& blade = scene.add_box(0, btVector3(0.05f, 0.2f, 0.2f), btVector3(-0.7f, 0.45f, 0));
    blade.setCollisionFlags(blade.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    blade.setActivationState(DISABLE_DEACTIVATION);
    scene.run(1);
    soil->set_enabled(false);
    scene.run(0.2);
    scene.world->setGravity(btVector3(0, 0, 0));
    scene.run(60);  // a minute passes
    place(blade, btVector3(0.7f, 0.45f, 0));
    place(box, kAbove - btVector3(0, 0.02f, 0));
    box.setLinearVelocity(btVector3(0, 0, 0));
    scene.world->setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
    const long long steps = soil->step_count();
    soil->set_enabled(true);
    double top_m_s = 0;
    for (int frame = 0; frame < 60; ++frame) {
        scene.run(1.0 / 60);
        top_m_s = std::max(top_m_s, static_cast<double>(box.getLinearVelocity().length()));
        if (frame == 0) {
            // The blade was set there, it did not plough its way through the bed.
            EXPECT_LT(length(soil->body_report(blade).force_n), 1);
            EXPECT_EQ(
                soil->soil().status_bits() & static_cast<uint32_t>(StatusBit::body_teleported), 0u);
        }
    }
    EXPECT_EQ(soil->step_count(), steps + 60);
    // It falls for the step in which the soil has not seen it yet, and no faster.
    EXPECT_LT(top_m_s, 1.1 * kGravity_m_s2 / 60);
    EXPECT_NEAR(soil->body_report(box).force_n.y, kWeightN, 0.1 * kWeightN);
    EXPECT_EQ(units_of(*soil), before);
}

// --- the host

struct TickLog {
    std::vector<btScalar> pre, post;
};

TEST(Host, its_tick_callbacks_stay_installed_and_are_called_as_before) {
    BulletScene scene;
    TickLog log;
    const auto pre = [](btDynamicsWorld* world, btScalar dt) {
        static_cast<TickLog*>(world->getWorldUserInfo())->pre.push_back(dt);
    };
    const auto post = [](btDynamicsWorld* world, btScalar dt) {
        static_cast<TickLog*>(world->getWorldUserInfo())->post.push_back(dt);
    };
    scene.world->setInternalTickCallback(pre, &log, true);
    scene.world->setInternalTickCallback(post, &log, false);
    {
        const auto soil = sand_bed(*scene.world);
        scene.add_box(kMassKg, kHalfBox, kAbove);
        scene.run(0.5, 4);
        EXPECT_EQ(scene.world->getWorldUserInfo(), &log);
    }
    EXPECT_EQ(log.pre.size(), 120u);
    EXPECT_EQ(log.post.size(), 120u);
    scene.run(0.5, 4);
    EXPECT_EQ(log.pre.size(), 240u);
    EXPECT_EQ(log.post.size(), 240u);
    for (const btScalar dt : log.pre) EXPECT_FLOAT_EQ(static_cast<float>(dt), 1.0f / 240);
}

/// A GL context of the host's own, without a window.
class HostContext {
  public:
    HostContext() {
        const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
            eglGetProcAddress("eglGetPlatformDisplayEXT"));
        if (!get_display) return;
        display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return;
        eglBindAPI(EGL_OPENGL_API);
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                                     EGL_NONE};
        context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
        if (context != EGL_NO_CONTEXT) {
            eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
        }
    }
    ~HostContext() {
        if (context == EGL_NO_CONTEXT) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
    }
    HostContext(const HostContext&) = delete;
    HostContext& operator=(const HostContext&) = delete;

    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
};

/// Everything that a compute pass could leave behind.
std::vector<GLint> gl_state() {
    std::vector<GLint> state(4);
    glGetIntegerv(GL_VIEWPORT, state.data());
    for (const GLenum name :
         {GL_CURRENT_PROGRAM, GL_ARRAY_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_BINDING,
          GL_UNIFORM_BUFFER_BINDING, GL_PIXEL_PACK_BUFFER_BINDING, GL_COPY_READ_BUFFER_BINDING,
          GL_COPY_WRITE_BUFFER_BINDING, GL_DISPATCH_INDIRECT_BUFFER_BINDING,
          GL_VERTEX_ARRAY_BINDING, GL_TEXTURE_BINDING_2D, GL_ACTIVE_TEXTURE,
          GL_DRAW_FRAMEBUFFER_BINDING, GL_UNPACK_ALIGNMENT}) {
        GLint value = -1;
        glGetIntegerv(name, &value);
        state.push_back(value);
    }
    for (GLuint i = 0; i < 9; ++i) {
        GLint value = -1;
        glGetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &value);
        state.push_back(value);
    }
    state.push_back(static_cast<GLint>(glGetError()));
    return state;
}

TEST(Host, its_gl_context_stays_current_and_its_state_untouched) {
    const HostContext host;
    if (host.context == EGL_NO_CONTEXT) GTEST_SKIP() << "no OpenGL 4.5 context to be had";
    GLuint buffers[2];
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[1]);
    const std::array<GLint, 3> content{7, 8, 9};
    glBufferData(GL_SHADER_STORAGE_BUFFER, sizeof content, content.data(), GL_STATIC_DRAW);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, buffers[1]);
    glViewport(1, 2, 33, 44);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
    const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
    const char* text = "#version 450\nlayout(local_size_x = 1) in;\nvoid main() {}\n";
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    const GLuint program = glCreateProgram();
    glAttachShader(program, shader);
    glLinkProgram(program);
    glUseProgram(program);
    const std::vector<GLint> before = gl_state();
    const auto check = [&](const char* when) {
        EXPECT_EQ(eglGetCurrentContext(), host.context) << when;
        EXPECT_EQ(eglQueryAPI(), static_cast<EGLenum>(EGL_OPENGL_API)) << when;
        EXPECT_EQ(gl_state(), before) << when;
    };
    {
        BulletScene scene;
        SoilDef def = small_bed();
        def.backend = Backend::gl;
        def.voxel_m = 0.1;
        auto soil = SoilAction::create(*scene.world, def);
        if (!soil) GTEST_SKIP() << soil.error();
        check("created");
        ASSERT_EQ((*soil)->soil().backend_name(), "gl");
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-2, -1, -2}, {2, 0.4, 2}}, def.material.name}));
        check("filled");
        scene.add_box(kMassKg, kHalfBox, kAbove);
        scene.run(0.1);
        check("stepped");
        EXPECT_GT((*soil)->soil().totals().units[0], 0);
        EXPECT_NE((*soil)->soil().checksum(), 0u);
        check("asked");
    }
    check("destroyed");
    std::array<GLint, 3> read{};
    glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof read, read.data());
    EXPECT_EQ(read, content);
    glDeleteProgram(program);
    glDeleteShader(shader);
    glDeleteBuffers(2, buffers);
}

// --- the world's gravity and the soil's

TEST(Gravity, another_than_the_worlds_is_refused_by_the_name_of_its_field) {
    BulletScene scene;
    const auto expect_refused = [&](const SoilDef& def, const std::string& start) {
        const auto soil = SoilAction::create(*scene.world, def);
        ASSERT_FALSE(soil) << start;
        EXPECT_EQ(soil.error().rfind(start, 0), 0u) << soil.error();
        EXPECT_EQ(scene.world->getNumCollisionObjects(), 0);
    };
    SoilDef def = small_bed();
    def.up = UpAxis::z;
    expect_refused(def, "up is z");
    def = small_bed();
    def.gravity_m_s2 = 1.62;
    expect_refused(def, "gravity_m_s2 is 1.62");
    scene.world->setGravity(btVector3(0, btScalar(9.81), 0));
    expect_refused(small_bed(), "up is y");
    // In another unit of length gravity has another size.
    const std::pair<btScalar, const char*> units[] = {{btScalar(981), "centimetres"},
                                                      {btScalar(9810), "millimetres"}};
    for (const auto& [g, unit] : units) {
        scene.world->setGravity(btVector3(0, -g, 0));
        const auto soil = SoilAction::create(*scene.world, small_bed());
        ASSERT_FALSE(soil) << unit;
        EXPECT_NE(soil.error().find(std::string("a world in ") + unit +
                                    "? The soil's units are SI; give the world metres"),
                  std::string::npos)
            << soil.error();
    }
    // Bullet's own default is near enough, and a world without gravity says nothing.
    for (const btScalar g : {btScalar(10), btScalar(0)}) {
        scene.world->setGravity(btVector3(0, -g, 0));
        EXPECT_TRUE(SoilAction::create(*scene.world, small_bed())) << g;
    }
}

TEST(Gravity, changed_after_the_soil_was_made_is_reported) {
    constexpr auto kDiffers = static_cast<uint32_t>(StatusBit::gravity_differs);
    BulletScene scene;
    scene.world->setGravity(btVector3(0, 0, 0));
    const auto soil = sand_bed(*scene.world);
    scene.run(0.1);
    EXPECT_EQ(soil->soil().status_bits(), 0u);
    scene.world->setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
    scene.run(0.1);
    EXPECT_EQ(soil->soil().status_bits(), 0u);
    scene.world->setGravity(btVector3(0, 0, btScalar(-kGravity_m_s2)));
    scene.run(0.1);
    EXPECT_EQ(soil->soil().status_bits(), kDiffers);
    EXPECT_EQ(soil->last_report().status_bits, kDiffers);
    EXPECT_EQ(status_texts(kDiffers).at(0).rfind("gravity_differs", 0), 0u);
    scene.world->setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
    soil->soil().clear_status();
    scene.run(0.1);
    EXPECT_EQ(soil->soil().status_bits(), 0u);
}

// --- settling

TEST(Settling, takes_no_time_in_the_world_and_leaves_soil_at_rest) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    ASSERT_TRUE(soil->fill(BoxFill{{{-0.3, kBedTopM, -0.3}, {0.3, 0.8, 0.3}}, {}}));
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, btVector3(0.7f, 0.55f, 0.7f));
    box.setLinearVelocity(btVector3(0, 0, 1));
    const int64_t units = units_of(*soil);
    const auto settled = soil->settle(3000);
    ASSERT_TRUE(settled) << settled.error();
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_GT(settled->step_count, 10);
    EXPECT_EQ(soil->step_count(), settled->step_count);
    EXPECT_EQ(units_of(*soil), units);
    EXPECT_LT(soil->surface_at({0, 0, 0})->position_m.y, 0.78);
    EXPECT_EQ(box.getWorldTransform().getOrigin().z(), btScalar(0.7f));
    EXPECT_EQ(box.getLinearVelocity().z(), btScalar(1));
    // Nothing of the heap moves in the world's own steps.
    scene.remove(box);
    const uint64_t checksum = soil->soil().checksum();
    EXPECT_EQ(soil->settle()->step_count, 0);
    EXPECT_EQ(soil->soil().checksum(), checksum);
}

TEST(Settling, a_body_in_its_place_bears_from_the_first_substep) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    // 2 cm deep: more than enough for its weight.
    btRigidBody& box =
        scene.add_box(kMassKg, kHalfBox, btVector3(0, btScalar(kBedTopM) + btScalar(0.18), 0));
    ASSERT_TRUE(soil->settle(10));
    EXPECT_GT(soil->body_report(box).patch_count, 0);
    scene.run(1.0 / 60);
    EXPECT_GT(soil->body_report(box).force_n.y, 0.2 * kWeightN);
}

TEST(Settling, says_why_it_cannot) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const auto refused = soil->settle(-1);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("steps_max"), std::string::npos) << refused.error();
    soil->set_enabled(false);
    const auto off = soil->settle();
    ASSERT_FALSE(off);
    EXPECT_NE(off.error().find("set_enabled"), std::string::npos) << off.error();
    EXPECT_EQ(soil->step_count(), 0);
}

// A playground of 62500 tiles: level ground costs no tile but those that something touches.
TEST(Settling, a_hundred_metres_of_level_ground_stay_asleep) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {100, 2, 100};
    const auto soil = sand_bed(*scene.world, def);
    EXPECT_LT(soil->soil().memory_use().asleep_bytes, 8'000'000);
    const auto settled = soil->settle();
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_EQ(settled->tile_awake_count, 0);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(31, 0, 17));
    scene.run(0.2);
    EXPECT_LE(soil->last_report().tile_awake_count, 36);
    EXPECT_GT(soil->body_report(box).force_n.y, 0.2 * kWeightN);
}

// --- several soils, several worlds

TEST(SeveralSoils, side_by_side_each_carries_what_stands_on_it) {
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    auto a = sand_bed(*scene.world, left);
    const auto b = sand_bed(*scene.world, right);
    btRigidBody& on_a = scene.add_box(kMassKg, kHalfBox, kAbove - btVector3(1, 0, 0));
    btRigidBody& on_b = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(1, 0, 0));
    btRigidBody& on_both = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(3);
    EXPECT_NEAR(a->body_report(on_a).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_NEAR(b->body_report(on_b).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_EQ(b->body_id(on_a), -1);
    const double lift_n = a->body_report(on_both).force_n.y + b->body_report(on_both).force_n.y;
    EXPECT_NEAR(lift_n, kWeightN, 0.05 * kWeightN);
    EXPECT_GT(a->body_report(on_both).force_n.y, 0.3 * kWeightN);
    // The first goes, the second stays whole.
    a.reset();
    scene.run(0.3);
    EXPECT_LT(height_of(on_a), kBedTopM - 0.1);
    EXPECT_NEAR(b->body_report(on_b).force_n.y, kWeightN, 0.05 * kWeightN);
}

TEST(SeveralSoils, do_not_see_one_another) {
    constexpr auto kOutside = static_cast<uint32_t>(StatusBit::body_outside_grid);
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    const auto a = sand_bed(*scene.world, left);
    auto b = sand_bed(*scene.world, right);
    // Its middle is in the right soil, a part of it in the left one.
    btRigidBody& seam = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(0.1f, 0, 0));
    scene.run(1);
    for (const auto* soil : {a.get(), b.get()}) {
        EXPECT_TRUE(soil->refused().empty()) << soil->refused()[0].reason;
        EXPECT_EQ(soil->soil().status_bits(), 0u);
    }
    // Where there is no other soil it is outside.
    b.reset();
    scene.run(0.1);
    EXPECT_EQ(a->soil().status_bits(), kOutside);
    EXPECT_TRUE(a->refused().empty());
    EXPECT_GE(a->body_id(seam), 0);
}

TEST(SeveralSoils, load_of_both_leaves_the_body_its_own_mass) {
    BulletScene scene;
    SoilDef left = small_bed(), right = small_bed();
    left.floor_center_m = {-1, 0, 0};
    right.floor_center_m = {1, 0, 0};
    const auto a = sand_bed(*scene.world, left);
    const auto b = sand_bed(*scene.world, right);
    // A board under soil of both grids.
    btRigidBody& board = scene.add_box(kMassKg, btVector3(0.4f, 0.1f, 0.2f), btVector3(0, 0.2f, 0));
    const btScalar inverse_mass = board.getInvMass();
    const btVector3 inverse_inertia = board.getInvInertiaDiagLocal();
    bool was_loaded_by_both = false;
    for (int frame = 0; frame < 120; ++frame) {
        scene.run(1.0 / 60);
        was_loaded_by_both |=
            a->body_report(board).load_kg > 0.1 && b->body_report(board).load_kg > 0.1;
        ASSERT_EQ(board.getInvMass(), inverse_mass) << frame;
        for (int i = 0; i < 3; ++i) {
            ASSERT_NEAR(board.getInvInertiaDiagLocal()[i], inverse_inertia[i],
                        1e-5 * inverse_inertia[i])
                << frame;
        }
    }
    EXPECT_TRUE(was_loaded_by_both) << "else nothing is tested";
}

/// A box falls on sand, is pushed along it; returns the soil's checksum.
uint64_t run_world(int seed) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.thread_count = 1 + seed % 2;
    const auto soil = sand_bed(*scene.world, def);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setLinearVelocity(btVector3(0.2f * btScalar(seed), -1, 0.3f));
    scene.run(1);
    return soil->soil().checksum();
}

TEST(SeveralWorlds, in_one_process_and_in_threads_are_as_alone) {
    constexpr int kCount = 4;
    std::array<uint64_t, kCount> alone{}, together{};
    for (int i = 0; i < kCount; ++i) alone[i] = run_world(i);
    std::vector<std::thread> threads;
    for (int i = 0; i < kCount; ++i) {
        threads.emplace_back([&together, i] { together[i] = run_world(i); });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(alone, together);
    for (int i = 1; i < kCount; ++i) EXPECT_NE(alone[i], alone[0]) << "they differ by their seeds";
}

TEST(SeveralWorlds, stepped_in_turns_are_as_alone) {
    const auto build = [](BulletScene& scene, int seed) {
        auto soil = sand_bed(*scene.world);
        scene.add_box(kMassKg, kHalfBox, kAbove)
            .setLinearVelocity(btVector3(0.2f * btScalar(seed), -1, 0.3f));
        return soil;
    };
    BulletScene first, second;
    const auto a = build(first, 1);
    const auto b = build(second, 2);
    for (int frame = 0; frame < 60; ++frame) {
        first.run(1.0 / 60);
        second.run(1.0 / 60);
    }
    EXPECT_EQ(a->soil().checksum(), run_world(1));
    EXPECT_EQ(b->soil().checksum(), run_world(2));
}

// --- axes

/// From a Y-up world to the Z-up world whose soil has the same grid: the grid's x is the world's z
/// with Y up, and its x with Z up.
btVector3 turned(const btVector3& v, bool z_up) {
    return z_up ? btVector3(v.z(), v.x(), v.y()) : v;
}

TEST(Axes, y_up_and_z_up_give_the_same_soil) {
    uint64_t checksums[2];
    std::vector<double> heights[2];
    double forces_n[2];
    for (const bool z_up : {false, true}) {
        BulletScene scene;
        scene.world->setGravity(turned(btVector3(0, btScalar(-kGravity_m_s2), 0), z_up));
        SoilDef def = small_bed();
        def.size_m = {1.6, 1, 2};
        // Of fixed density: contact forces, reckoned in the body's axes, do not act back on it.
        def.material.loose_density_kg_m3 = def.material.compacted_density_kg_m3 = 0;
        if (z_up) {
            def.up = UpAxis::z;
            def.size_m = {2, 1.6, 1};
        }
        const auto soil = sand_bed(*scene.world, def);
        btRigidBody& box =
            scene.add_box(kMassKg, turned(btVector3(0.2f, 0.15f, 0.1f), z_up),
                          turned(btVector3(-0.1f, btScalar(kBedTopM) + 0.17f, 0.05f), z_up));
        // Kinematic: what Bullet rounds in a solve depends on the order of the axes.
        box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        box.setActivationState(DISABLE_DEACTIVATION);
        for (int frame = 1; frame <= 60; ++frame) {
            const btScalar t = btScalar(frame) / 64;
            // No multiples of a voxel's parts, which fall to either side by the last bit.
            place(box, turned(btVector3(-0.1237f + 0.2413f * t,
                                        btScalar(kBedTopM) + 0.1711f - 0.2419f * t, 0.0613f),
                              z_up));
            scene.run(1.0 / 60);
        }
        checksums[z_up] = soil->soil().checksum();
        forces_n[z_up] = length(soil->body_report(box).force_n);
        const int* size = soil->soil().frame().size;
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x) {
                heights[z_up].push_back(soil->soil().surface_height_m(x, y));
            }
        }
    }
    EXPECT_EQ(heights[0], heights[1]);
    EXPECT_EQ(checksums[0], checksums[1]);
    EXPECT_GT(forces_n[0], 100);
    EXPECT_NEAR(forces_n[0], forces_n[1], 1e-3 * forces_n[0]);
}

TEST(Axes, a_dropped_box_comes_to_the_same_rest_with_y_up_and_with_z_up) {
    double heights[2], lifts_n[2];
    for (const bool z_up : {false, true}) {
        BulletScene scene;
        scene.world->setGravity(turned(btVector3(0, btScalar(-kGravity_m_s2), 0), z_up));
        SoilDef def = small_bed();
        def.size_m = z_up ? Vec3{2, 2, 1} : Vec3{2, 1, 2};
        def.up = z_up ? UpAxis::z : UpAxis::y;
        const auto soil = sand_bed(*scene.world, def);
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, turned(kAbove, z_up));
        scene.run(3);
        heights[z_up] = static_cast<double>(box.getWorldTransform().getOrigin()[z_up ? 2 : 1]);
        const Vec3 force_n = soil->body_report(box).force_n;
        lifts_n[z_up] = z_up ? force_n.z : force_n.y;
    }
    EXPECT_NEAR(heights[0], heights[1], 1e-4);
    EXPECT_NEAR(lifts_n[0], lifts_n[1], 0.01 * kWeightN);
}

// --- time

/// How a host steps its world: stepSimulation(dt, max_substeps, fixed_s).
struct Stepping {
    const char* name;
    double dt_s;
    int max_substeps;
    double fixed_s;
    double soil_step_s;
};

class SteppedWorlds : public testing::TestWithParam<Stepping> {};

TEST_P(SteppedWorlds, a_body_at_rest_is_carried_with_its_weight) {
    const Stepping& p = GetParam();
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {1, 1, 1};
    def.step_s = p.soil_step_s;
    const auto soil = sand_bed(*scene.world, def);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setActivationState(DISABLE_DEACTIVATION);
    double time_s = 0, impulse_n_s = 0;
    // The report is that of the last substep: asked after each.
    struct Probe {
        SoilAction* soil;
        btRigidBody* box;
        double impulse_n_s = 0, time_s = 0;
        bool counts = false;
    } probe{soil.get(), &box};
    scene.world->setInternalTickCallback(
        [](btDynamicsWorld* world, btScalar dt) {
            auto* seen = static_cast<Probe*>(world->getWorldUserInfo());
            if (!seen->counts) return;
            const BodyReport report = seen->soil->body_report(*seen->box);
            seen->impulse_n_s +=
                (report.force_n.y - report.load_kg * kGravity_m_s2) * static_cast<double>(dt);
            seen->time_s += static_cast<double>(dt);
        },
        &probe);
    const auto run = [&](double seconds) {
        for (double t = 0; t < seconds - 1e-9; t += p.dt_s) {
            scene.world->stepSimulation(static_cast<btScalar>(p.dt_s), p.max_substeps,
                                        static_cast<btScalar>(p.fixed_s));
        }
    };
    run(1);
    const btScalar from = box.getLinearVelocity().y();
    probe.counts = true;
    run(1);
    time_s = probe.time_s;
    // What changed its speed was not its weight.
    impulse_n_s = probe.impulse_n_s - 50 * static_cast<double>(box.getLinearVelocity().y() - from);
    ASSERT_GT(time_s, 0.1);
    EXPECT_NEAR(impulse_n_s / time_s, kWeightN, 0.01 * kWeightN);
    EXPECT_LT(std::abs(static_cast<double>(box.getLinearVelocity().y())), 0.02);
    EXPECT_GT(height_of(box), kBedTopM + 0.1);
}

INSTANTIATE_TEST_SUITE_P(
    Steps, SteppedWorlds,
    testing::Values(Stepping{"variable", 1.0 / 60, 0, 1.0 / 60, 1.0 / 60},
                    Stepping{"variable_long", 1.0 / 30, 0, 1.0 / 60, 1.0 / 60},
                    Stepping{"one_of_60", 1.0 / 60, 1, 1.0 / 60, 1.0 / 60},
                    Stepping{"one_of_240", 1.0 / 60, 1, 1.0 / 240, 1.0 / 60},
                    Stepping{"ten_of_240", 1.0 / 60, 10, 1.0 / 240, 1.0 / 60},
                    Stepping{"ten_of_1000", 1.0 / 100, 10, 1.0 / 1000, 1.0 / 60},
                    Stepping{"soil_shorter", 1.0 / 60, 10, 1.0 / 60, 1.0 / 240},
                    Stepping{"soil_longer", 1.0 / 60, 10, 1.0 / 240, 1.0 / 30},
                    Stepping{"soil_out_of_step", 1.0 / 60, 10, 1.0 / 60, 1.0 / 100},
                    Stepping{"frame_of_a_third", 1.0 / 20, 10, 1.0 / 60, 1.0 / 60}),
    [](const auto& named) { return std::string(named.param.name); });

TEST(Time, changing_steps_and_none_at_all_do_no_harm) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const int64_t before = units_of(*soil);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    double passed_s = 0;
    for (int i = 0; i < 200; ++i) {
        const double dt_s = (1 + i % 7) / 240.0;
        scene.world->stepSimulation(static_cast<btScalar>(dt_s), 0);
        passed_s += dt_s;
        const uint64_t checksum = soil->soil().checksum();
        const long long steps = soil->step_count();
        const btTransform pose = box.getWorldTransform();
        scene.world->stepSimulation(0, i % 2);
        scene.world->stepSimulation(-1, 1);
        EXPECT_EQ(soil->soil().checksum(), checksum);
        EXPECT_EQ(soil->step_count(), steps);
        EXPECT_EQ(box.getWorldTransform().getOrigin(), pose.getOrigin());
    }
    EXPECT_NEAR(static_cast<double>(soil->step_count()), 60 * passed_s, 1);
    EXPECT_NEAR(soil->body_report(box).force_n.y, kWeightN, 0.05 * kWeightN);
    EXPECT_EQ(units_of(*soil), before);
}

TEST(Time, negative_variable_step_is_no_step_of_the_soil) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(0.5);
    const uint64_t checksum = soil->soil().checksum();
    scene.world->stepSimulation(btScalar(-1) / 60, 0);
    EXPECT_EQ(soil->soil().checksum(), checksum);
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    scene.run(0.1);
    EXPECT_TRUE(is_finite(*scene.bodies[0]));
}

}  // namespace
}  // namespace bsoil::bullet
