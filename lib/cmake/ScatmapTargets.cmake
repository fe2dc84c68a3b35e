# One target per room. scatmap_room(NAME LINKS ...) builds scatmap_NAME from every .cpp in its folder; the
# LINKS lists are the dependency diagram, and tests/layering_test.cpp holds the #include lines to it.

add_library(scatmap_flags INTERFACE)
target_compile_options(scatmap_flags INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
  # One legal result per expression, whatever the instruction set: fused multiply-adds are written where wanted.
  -ffp-contract=off -fno-math-errno
  # g++ 12 warns wrongly about std::string operator+ (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(SCATMAP_SANITIZE)
  target_compile_options(scatmap_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined
    -fno-omit-frame-pointer)
  target_link_options(scatmap_flags INTERFACE -fsanitize=address,undefined)
endif()
if(SCATMAP_TSAN)
  target_compile_options(scatmap_flags INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(scatmap_flags INTERFACE -fsanitize=thread)
endif()
if(SCATMAP_FUZZ)
  target_compile_options(scatmap_flags INTERFACE -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow
    -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(scatmap_flags INTERFACE -fsanitize=address,undefined)
endif()

function(scatmap_room name)
  cmake_parse_arguments(ROOM "" "FOLDER" "LINKS;PRIVATE_LINKS" ${ARGN})
  if(NOT ROOM_FOLDER)
    set(ROOM_FOLDER ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${ROOM_FOLDER}/*.cpp)
  add_library(scatmap_${name} STATIC ${sources})
  add_library(scatmap::${name} ALIAS scatmap_${name})
  set_target_properties(scatmap_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(scatmap_${name} PUBLIC cxx_std_20)
  target_link_libraries(scatmap_${name} PUBLIC ${ROOM_LINKS} PRIVATE ${ROOM_PRIVATE_LINKS} $<BUILD_INTERFACE:scatmap_flags>)
endfunction()
