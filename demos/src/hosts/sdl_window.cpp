/// A host with a window of its own: SDL makes it, Bullet moves a ball, the soil gives way, and the
/// renderer draws both into the window. Drag to look around, space drops the ball again, escape
/// leaves. `sdl_window STEPS` leaves after that number of steps and checks that a crater is seen.
#include <SDL.h>
#include <btBulletDynamicsCommon.h>
#include <epoxy/gl.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/render/primitives.h"
#include "bsoil/render/renderer.h"

namespace {

constexpr double kRadiusM = 0.25, kMassKg = 200, kBedTopM = 0.4;

/// The ball's world.
struct World {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld bullet{&dispatcher, &broadphase, &solver, &configuration};
    btSphereShape shape{btScalar(kRadiusM)};
    btRigidBody ball{btRigidBody::btRigidBodyConstructionInfo(
        btScalar(kMassKg), nullptr, &shape,
        btVector3(1, 1, 1) * btScalar(0.4 * kMassKg * kRadiusM * kRadiusM))};

    World() {
        bullet.setGravity({0, btScalar(-9.81), 0});
        bullet.addRigidBody(&ball);
        drop();
    }
    ~World() { bullet.removeRigidBody(&ball); }
    void drop() {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin({0, 2, 0});
        ball.setWorldTransform(pose);
        ball.setLinearVelocity({0, 0, 0});
        ball.setAngularVelocity({0, 0, 0});
        ball.activate(true);
    }
};

bsoil::Pose pose_of(const btRigidBody& body) {
    const btVector3& p = body.getWorldTransform().getOrigin();
    const btQuaternion q = body.getWorldTransform().getRotation();
    return {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

/// A window with OpenGL 3.3 core.
struct Window {
    SDL_Window* window = nullptr;
    SDL_GLContext context = nullptr;

    bool open() {
        if (SDL_Init(SDL_INIT_VIDEO) != 0) return false;
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3);
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
        window =
            SDL_CreateWindow("Soil in a window", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
                             960, 600, SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE);
        if (window) context = SDL_GL_CreateContext(window);
        return context != nullptr;
    }
    ~Window() {
        if (context) SDL_GL_DeleteContext(context);
        if (window) SDL_DestroyWindow(window);
        SDL_Quit();
    }
};

/// What the person at the window wants.
struct Wishes {
    double yaw_rad = 0.6;
    bool leave = false, drop = false;

    void take_events() {
        drop = false;
        for (SDL_Event event; SDL_PollEvent(&event);) {
            if (event.type == SDL_QUIT) leave = true;
            if (event.type == SDL_MOUSEMOTION && (event.motion.state & SDL_BUTTON_LMASK) != 0) {
                yaw_rad -= 0.01 * event.motion.xrel;
            }
            if (event.type != SDL_KEYDOWN) continue;
            leave = leave || event.key.keysym.sym == SDLK_ESCAPE;
            drop = drop || event.key.keysym.sym == SDLK_SPACE;
        }
    }
};

/// Pixels of the window that are much darker than its mean: what lies in the shadow.
int dark_pixel_count(int width, int height) {
    std::vector<unsigned char> pixels(4 * static_cast<size_t>(width) * static_cast<size_t>(height));
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    int count = 0;
    for (size_t p = 0; p < pixels.size(); p += 4) {
        count += pixels[p] + pixels[p + 1] + pixels[p + 2] < 150;
    }
    return count;
}

}  // namespace

int main(int argument_count, char** arguments) {
    const int step_target = argument_count > 1 ? std::atoi(arguments[1]) : 0;
    World world;
    bsoil::SoilDef def;
    def.size_m = {4, 1.2, 4};
    auto soil = bsoil::bullet::SoilAction::create(world.bullet, def);
    if (!soil) {
        std::printf("%s\n", soil.error().c_str());
        return 2;
    }
    if (!(*soil)->fill(bsoil::BoxFill{{{-2, 0, -2}, {2, kBedTopM, 2}}, "dry_sand"})) return 2;

    Window window;
    if (!window.open()) return std::printf("no window: %s\n", SDL_GetError()), 77;
    bsoil::render::RendererDef renderer_def;
    renderer_def.callers_context = true;  // the one that SDL has just made current
    auto renderer = bsoil::render::Renderer::create(renderer_def);
    if (!renderer) {
        std::printf("%s\n", renderer.error().c_str());
        return 2;
    }

    // The soil's surface is kept up to date tile by tile; the ball is one mesh that moves.
    bsoil::SoilTiles tiles((*soil)->soil());
    bsoil::SurfaceMesher mesher(tiles);
    bsoil::render::SurfaceItems surface(**renderer, mesher, 0.02f);
    bsoil::render::Item ball;
    ball.mesh = (*renderer)->add_mesh(bsoil::render::sphere_mesh(kRadiusM, {0.55f, 0.1f, 0.06f}));
    ball.gloss = 0.5f;

    Wishes wishes;
    int dark_pixels = 0;
    for (int step = 0; !wishes.leave && (step_target == 0 || step < step_target); ++step) {
        wishes.take_events();
        if (wishes.drop) world.drop();
        world.bullet.stepSimulation(btScalar(1.0 / 60), 4, btScalar(1.0 / 240));

        bsoil::render::View view;
        SDL_GL_GetDrawableSize(window.window, &view.width, &view.height);
        view.camera.target = {0, kBedTopM, 0};
        view.camera.eye = {4 * std::sin(wishes.yaw_rad), 2.2, 4 * std::cos(wishes.yaw_rad)};
        view.floor_height_m = 0;
        mesher.update();
        surface.update();
        surface.append_to(view.items);
        ball.pose = pose_of(world.ball);
        view.items.push_back(ball);
        if (const bsoil::Status drawn = (*renderer)->draw(view, 0); !drawn) {
            std::printf("%s\n", drawn.error().c_str());
            return 2;
        }
        if (step + 1 == step_target) dark_pixels = dark_pixel_count(view.width, view.height);
        SDL_GL_SwapWindow(window.window);
    }
    if (step_target == 0) return 0;
    const double sunk_m = kBedTopM + kRadiusM - ball.pose.position.y;
    std::printf("the ball has sunk %.0f mm; %d pixels of the window are in shadow\n", 1e3 * sunk_m,
                dark_pixels);
    return sunk_m > 0.02 && dark_pixels > 100 ? 0 : 1;
}
