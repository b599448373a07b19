# Included from plugin/CMakeLists.txt after bulletsoil_soil exists.
target_sources(bulletsoil_soil PRIVATE
  ${CMAKE_CURRENT_LIST_DIR}/bare_walls.cpp
  ${CMAKE_CURRENT_LIST_DIR}/coarse_error.cpp
  ${CMAKE_CURRENT_LIST_DIR}/column_runs.cpp
  ${CMAKE_CURRENT_LIST_DIR}/device_mesher.cpp
  ${CMAKE_CURRENT_LIST_DIR}/display_field.cpp
  ${CMAKE_CURRENT_LIST_DIR}/kept_meshes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/look_words.cpp
  ${CMAKE_CURRENT_LIST_DIR}/marching_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mesh_export.cpp
  ${CMAKE_CURRENT_LIST_DIR}/plane_strips.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rolling_soil.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shared_surface.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soil_color.cpp
  ${CMAKE_CURRENT_LIST_DIR}/soil_tiles.cpp
  ${CMAKE_CURRENT_LIST_DIR}/split_cell.cpp
  ${CMAKE_CURRENT_LIST_DIR}/surface_mesher.cpp
  ${CMAKE_CURRENT_LIST_DIR}/tile_levels.cpp
  ${CMAKE_CURRENT_LIST_DIR}/tile_mesher.cpp
  ${CMAKE_CURRENT_LIST_DIR}/vertex_writer.cpp
)
