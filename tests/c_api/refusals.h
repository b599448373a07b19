/* Cases of c_api_test in which something cannot be. */
#ifndef BSOIL_TESTS_REFUSALS_H
#define BSOIL_TESTS_REFUSALS_H

void the_other_precision_is_refused(void);
void bad_definitions_are_refused(void);
void sizes_of_structs_are_kept(void);
void shorter_definitions_get_defaults(void);
void bad_arguments_are_refused(void);
void another_gravity_than_the_worlds_is_refused(void);

#endif
