// What a host sees of the soil in its world: switching it on and off, callbacks, GL, gravity.
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <functional>
#include <new>
#include <utility>

#include "bsoil/bullet/world_snapshot.h"
#include "temporary_file.h"
#include "test_box.h"

namespace bsoil::bullet::host_test {
namespace {

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

// Rows and preloads stayed in. Where no substep came, Bullet cleared the forces, and the next one
// took the preloads off once more.
TEST(Host, may_look_for_contacts_between_steps) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setActivationState(DISABLE_DEACTIVATION);
    scene.run(2);
    ASSERT_GT(soil->body_report(box).force_n.y, kWeightN / 2);
    for (const bool looks_for_contacts : {false, true}) {
        looks_for_contacts ? scene.world->performDiscreteCollisionDetection()
                           : scene.world->updateAabbs();
        EXPECT_EQ(scene.world->getNumConstraints(), 0);
        EXPECT_EQ(box.getTotalForce().length(), 0);
    }
    scene.run(1.0 / 60);
    EXPECT_GT(soil->body_report(box).force_n.y, kWeightN / 2) << "it goes on";
}

/// A world of a host that has its own substep and does not tell of it.
struct SilentWorld final : btDiscreteDynamicsWorld {
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
    void updateAabbs() override {
        getDispatchInfo().m_stepCount = 1;
        btDiscreteDynamicsWorld::updateAabbs();
    }
};

/// One with a bed and a box over it.
struct SilentScene {
    BulletScene scene;
    btSequentialImpulseConstraintSolver solver;
    SilentWorld world{&scene.dispatcher, &scene.broadphase, &solver, &scene.configuration};
    std::unique_ptr<SoilAction> soil;
    btBoxShape shape{kHalfBox};
    std::unique_ptr<btRigidBody> box;

    SilentScene() {
        world.setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
        soil = sand_bed(world);
        btVector3 inertia;
        shape.calculateLocalInertia(kMassKg, inertia);
        box = std::make_unique<btRigidBody>(kMassKg, nullptr, &shape, inertia);
        place(*box, kAbove);
        world.addRigidBody(box.get());
    }
    ~SilentScene() { world.removeRigidBody(box.get()); }
    void run(int frames) {
        for (int i = 0; i < frames; ++i) world.stepSimulation(btScalar(1) / 60);
    }
};

TEST(Host, whose_world_does_not_tell_of_substeps_is_served) {
    SilentScene silent;
    silent.run(60);
    EXPECT_GT(height_of(*silent.box), kBedTopM);
}

// The restored box fell through the first substep. What its soil knew of its world was not saved.
TEST(Host, whose_world_does_not_tell_of_substeps_goes_on_from_a_snapshot) {
    const TemporaryFile file("silent_world.snapshot");
    SilentScene saved, restored;
    saved.run(60);
    ASSERT_GT(saved.soil->body_report(*saved.box).force_n.y, 0.9 * kWeightN);
    SoilAction* soil = saved.soil.get();
    const Status written = save_world(saved.world, {&soil, 1}, file.path());
    ASSERT_TRUE(written) << written.error();
    soil = restored.soil.get();
    const Status read = load_world(restored.world, {&soil, 1}, file.path());
    ASSERT_TRUE(read) << read.error();
    for (SilentScene* silent : {&saved, &restored}) silent->run(1);
    EXPECT_EQ(height_of(*restored.box), height_of(*saved.box));
    EXPECT_EQ(restored.box->getLinearVelocity(), saved.box->getLinearVelocity());
}

/// A body whose memory the test keeps, to see who writes there once it is gone.
class WatchedBody {
  public:
    WatchedBody(BulletScene& scene, const btVector3& half, const btVector3& at) : scene_(scene) {
        btCollisionShape& shape = scene.shape<btBoxShape>(half);
        btVector3 inertia;
        shape.calculateLocalInertia(kMassKg, inertia);
        body_ = ::new (memory_.data()) btRigidBody(kMassKg, nullptr, &shape, inertia);
        place(*body_, at);
        scene.world->addRigidBody(body_);
    }
    ~WatchedBody() { erase(); }
    WatchedBody(const WatchedBody&) = delete;
    WatchedBody& operator=(const WatchedBody&) = delete;

    const btRigidBody& body() const { return *body_; }
    void erase() {
        if (!body_) return;
        scene_.world->removeRigidBody(body_);
        std::exchange(body_, nullptr)->~btRigidBody();
        memory_.fill(kGone);
    }
    bool is_untouched() const {
        return std::ranges::all_of(memory_, [](unsigned char byte) { return byte == kGone; });
    }

  private:
    static constexpr unsigned char kGone = 0xcd;
    BulletScene& scene_;
    alignas(btRigidBody) std::array<unsigned char, sizeof(btRigidBody)> memory_{};
    btRigidBody* body_ = nullptr;
};

class DeletingAction final : public btActionInterface {
  public:
    void updateAction(btCollisionWorld*, btScalar) override {
        if (const auto act = std::exchange(act_, nullptr)) act();
    }
    void debugDraw(btIDebugDraw*) override {}
    void set(std::function<void()> act) { act_ = std::move(act); }

  private:
    std::function<void()> act_;
};

// Its rows are in the world until the soil's own action, and what they had given was taken back.
TEST(Host, may_delete_a_body_in_an_action_ahead_of_the_soils) {
    BulletScene scene;
    DeletingAction action;
    scene.world->addAction(&action);
    const auto soil = sand_bed(*scene.world);
    const btVector3 aside(btScalar(0.5), 0, 0);
    WatchedBody gone(scene, kHalfBox, kAbove - aside);
    const btRigidBody& stays = scene.add_box(kMassKg, kHalfBox, kAbove + aside);
    scene.run(1);
    ASSERT_GT(soil->body_report(gone.body()).force_n.y, 0.5 * kWeightN);
    action.set([&gone] { gone.erase(); });
    scene.run(1.0 / 60);
    EXPECT_TRUE(gone.is_untouched());
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    scene.run(0.5);
    EXPECT_NEAR(soil->body_report(stays).force_n.y, kWeightN, 0.1 * kWeightN);
}

// The same of a body that carries the soil under another.
TEST(Host, may_delete_a_carrier_in_an_action_ahead_of_the_soils) {
    BulletScene scene;
    DeletingAction action;
    scene.world->addAction(&action);
    const auto made = SoilAction::create(*scene.world, small_bed());
    ASSERT_TRUE(made) << made.error();
    SoilAction& soil = **made;
    const btScalar wide = btScalar(0.5), thin = btScalar(0.05);
    scene.add_box(0, {wide, btScalar(0.15), wide}, {0, btScalar(0.15), 0});
    WatchedBody tray(scene, {wide, thin, wide}, {0, btScalar(0.35), 0});
    ASSERT_TRUE(soil.fill(BoxFill{{{-0.4, 0.4, -0.4}, {0.4, 0.55, 0.4}}, {}}));
    scene.run(0.5);
    const btScalar half = btScalar(0.1);
    const btRigidBody& rock =
        scene.add_box(kMassKg, {half, half, half}, {0, btScalar(0.55) + half, 0});
    scene.run(1);
    ASSERT_GT(soil.body_report(tray.body()).load_kg, 20);
    ASSERT_GT(soil.body_report(rock).force_n.y, 0.5 * kWeightN);
    action.set([&tray] { tray.erase(); });
    scene.run(1.0 / 60);
    EXPECT_TRUE(tray.is_untouched());
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    scene.run(0.5);
    EXPECT_TRUE(is_finite(rock));
}

TEST(Host, its_gl_context_stays_current_and_its_state_untouched) {
    const HostContext host;
    if (host.context == EGL_NO_CONTEXT) {
        GTEST_SKIP() << "no OpenGL 4.5 context to be had";
    }
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
        if (!soil) {
            GTEST_SKIP() << soil.error();
        }
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

}  // namespace
}  // namespace bsoil::bullet::host_test
