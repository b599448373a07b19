/* A Bullet world for the tests of the C interface, made where C++ and btScalar are known. */
#ifndef BSOIL_TESTS_C_API_TEST_WORLD_H
#define BSOIL_TESTS_C_API_TEST_WORLD_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A btDiscreteDynamicsWorld with gravity along -y, empty. */
void* test_world_create(void);
/* A btSimpleDynamicsWorld, which cannot hold soil. */
void* test_world_create_simple(void);
void test_world_destroy(void* world);
/* Steps of 1/60 s. */
void test_world_step(void* world, int count);
/* A ball of 0.3 m radius at rest, its centre at this height; a btRigidBody that goes with the
 * world. */
void* test_world_add_ball(void* world, double mass_kg, double height_m);
/* Height of its centre now. */
double test_world_ball_y(const void* ball);
/* Puts it somewhere else at its height, at rest. */
void test_world_move_ball(void* ball, double x, double z);
/* A body with a shape that the soil refuses, lying at y = 0. */
void* test_world_add_empty(void* world);
size_t test_world_scalar_bytes(void);
/* Whether the text of an error says what may be, or what to do. */
int test_says_what_to_do(const char* text);

#ifdef __cplusplus
}
#endif

#endif
