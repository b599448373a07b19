# Writes a file for ctest with one test for each suite of a GoogleTest program:
# cmake -D PROGRAM=PATH -D PREFIX=NAME -D FILTER=FILTER -D FILE=PATH -D FOLDER=PATH -D "PROPERTIES=NAME VALUE..."
#       -P discover_suites.cmake
# Suites of two programs may have one name, tests may not: PREFIX comes before it. FILTER leaves out whole suites alone.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests --gtest_filter=${FILTER} OUTPUT_VARIABLE listed
                COMMAND_ERROR_IS_FATAL ANY)
# Values of parameters stand after '#' and may be anything.
string(REGEX REPLACE "#[^\n]*" "" listed "${listed}")
string(REPLACE "\n" ";" lines "${listed}")
set(suites)
foreach(line IN LISTS lines)
  if(line MATCHES "^([^ ]+)\\. *$")
    set(suite ${CMAKE_MATCH_1})
    list(APPEND suites ${suite})
    set(cases_of_${suite} 0)
  elseif(line MATCHES "^  ")
    math(EXPR cases_of_${suite} "${cases_of_${suite}} + 1")
  endif()
endforeach()

set(content)
foreach(suite IN LISTS suites)
  # COST: those of many cases first, while no times are known. Skipped is a suite of which every case is.
  string(APPEND content "add_test([[${PREFIX}.${suite}]] [[${PROGRAM}]] [[--gtest_filter=${suite}.*]])\n"
         "set_tests_properties([[${PREFIX}.${suite}]] PROPERTIES COST ${cases_of_${suite}} SKIP_REGULAR_EXPRESSION "
         "[[\\[  PASSED  \\] 0 tests\\.\n(\\[  SKIPPED \\][^\n]*\n)+$]] WORKING_DIRECTORY [[${FOLDER}]] ${PROPERTIES})\n")
endforeach()
file(WRITE ${FILE} "${content}")
