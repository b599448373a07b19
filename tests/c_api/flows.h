/* Cases about soil, water and air that come and go. */
#ifndef BSOIL_TESTS_C_API_FLOWS_H
#define BSOIL_TESTS_C_API_FLOWS_H

void soil_is_poured_and_taken_to_the_unit(void);
void sources_and_sinks_move(void);
void sinks_have_the_forms_of_bodies(void);
void water_is_counted_to_the_unit(void);
void wells_say_what_they_have_moved(void);
void wind_carries_what_falls(void);

#endif
