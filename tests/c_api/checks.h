/* Checks that end the program, and the soil that most cases start with. */
#ifndef BSOIL_TESTS_CHECKS_H
#define BSOIL_TESTS_CHECKS_H

#include <bsoil/c/bulletsoil.h>

/* Fails the program; `what` is the condition's text, `where` its file and line. */
void check(int condition, const char* what, const char* where);
#define TEXT_OF(x) #x
#define TEXT_OF_VALUE(x) TEXT_OF(x)
#define HERE __FILE__ ":" TEXT_OF_VALUE(__LINE__)
#define CHECK(condition) check((condition) != 0, #condition, HERE)
#define CHECK_OK(call) check((call) == BULLETSOIL_OK, #call, HERE)

/* A failure with a text that has `word` in it. */
void check_error(bulletsoil_result found, bulletsoil_result expected, const char* word,
                 const char* what, const char* where);
#define CHECK_ERROR(call, code, word) check_error((call), (code), (word), #call, HERE)
#define CHECK_INVALID(call, word) CHECK_ERROR(call, BULLETSOIL_INVALID_ARGUMENT, word)

bulletsoil_soil_def small_def(void);
bulletsoil_soil* create(void* world, const bulletsoil_soil_def* def);

extern const double bed_min_m[3], bed_max_m[3];
/* A bed of sand of 2 x 0.5 x 2 m under a world. */
bulletsoil_soil* create_bed(void* world);

uint64_t checksum(const bulletsoil_soil* soil);
double surface_height_m(const bulletsoil_soil* soil, double x_m, double z_m);

#endif
