/**
 * The C interface: what each of its functions takes and returns.
 */
#ifndef BSOIL_C_BULLETSOIL_RESULT_H
#define BSOIL_C_BULLETSOIL_RESULT_H

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/** A soil and its coupling to a world. */
typedef struct bulletsoil_soil bulletsoil_soil;

/** What a call came to. */
typedef enum bulletsoil_result {
    BULLETSOIL_OK = 0,
    BULLETSOIL_INVALID_ARGUMENT = 1, /**< a null pointer, a dead handle, a value out of range */
    BULLETSOIL_WRONG_PRECISION = 2,  /**< the world is of the other one of Bullet's precisions */
    BULLETSOIL_FAILED = 3,           /**< a device or a file cannot be used */
    BULLETSOIL_OUT_OF_MEMORY = 4,
    BULLETSOIL_INTERNAL_ERROR = 5 /**< a defect of the library */
} bulletsoil_result;

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#endif
