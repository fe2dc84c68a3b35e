# Finds every dependency; a missing one is an error that names its Debian package.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)

function(scatmap_missing what package)
  message(FATAL_ERROR "scatmap needs ${what}. Install it with: apt-get install --no-install-recommends ${package}")
endfunction()

# A CMake package or nothing; CONFIG files of some Debian packages are chatty, so they are read quietly.
macro(scatmap_find name package)
  find_package(${name} QUIET ${ARGN})
  if(NOT ${name}_FOUND)
    scatmap_missing(${name} ${package})
  endif()
endmacro()

macro(scatmap_find_pkgconfig target module package)
  pkg_check_modules(${target} QUIET IMPORTED_TARGET ${module})
  if(NOT ${target}_FOUND)
    scatmap_missing(${module} ${package})
  endif()
endmacro()

scatmap_find(Eigen3 libeigen3-dev NO_MODULE)
scatmap_find(OpenEXR libopenexr-dev)
scatmap_find(CLI11 libcli11-dev)
scatmap_find(nlohmann_json nlohmann-json3-dev)
scatmap_find(tomlplusplus libtomlplusplus-dev)
scatmap_find(TBB libtbb-dev)
scatmap_find(TIFF libtiff-dev)
set(SCATMAP_MESSAGE_LEVEL ${CMAKE_MESSAGE_LOG_LEVEL})
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)  # Ceres' own file talks for a page
scatmap_find(Ceres libceres-dev)
set(CMAKE_MESSAGE_LOG_LEVEL ${SCATMAP_MESSAGE_LEVEL})
scatmap_find(PNG libpng-dev)
scatmap_find_pkgconfig(CFITSIO cfitsio libcfitsio-dev)
scatmap_find_pkgconfig(NETTLE nettle nettle-dev)

# OpenCV's CMake files come only with libopencv-dev (1.4 GB); the module packages are enough.
foreach(module core imgproc calib3d)
  find_library(OPENCV_${module}_LIBRARY opencv_${module})
  find_path(OPENCV_${module}_INCLUDE opencv2/${module}.hpp PATH_SUFFIXES opencv4)
  if(NOT OPENCV_${module}_LIBRARY OR NOT OPENCV_${module}_INCLUDE)
    scatmap_missing("OpenCV ${module}" libopencv-${module}-dev)
  endif()
  if(NOT TARGET scatmap_opencv_${module})
    add_library(scatmap_opencv_${module} INTERFACE IMPORTED)
    set_target_properties(scatmap_opencv_${module} PROPERTIES
      INTERFACE_LINK_LIBRARIES "${OPENCV_${module}_LIBRARY}"
      INTERFACE_INCLUDE_DIRECTORIES "${OPENCV_${module}_INCLUDE}")
  endif()
endforeach()

find_path(MRCAL_INCLUDE mrcal/mrcal.h)
find_library(MRCAL_LIBRARY mrcal)
if(NOT MRCAL_INCLUDE OR NOT MRCAL_LIBRARY)
  scatmap_missing(mrcal libmrcal-dev)
endif()

find_program(GNUPLOT gnuplot)
if(NOT GNUPLOT)
  scatmap_missing(gnuplot gnuplot-nox)
endif()

if(SCATMAP_TESTS)
  scatmap_find(GTest libgtest-dev)
endif()
if(SCATMAP_BENCHMARKS)
  scatmap_find(benchmark libbenchmark-dev)
endif()
