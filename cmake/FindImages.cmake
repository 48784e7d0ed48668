# OpenImageIO, found by its files: the package of Debian 12 brings a CMake configuration that demands the tools and the headers of
# OpenCV, neither of which is needed here. Sets FACETFIT_IMAGES_INCLUDE and FACETFIT_IMAGES_LIBRARIES.
find_path(FACETFIT_IMAGES_INCLUDE OpenImageIO/imageio.h)
find_library(FACETFIT_IMAGES_LIBRARY OpenImageIO)
find_library(FACETFIT_IMAGES_UTIL_LIBRARY OpenImageIO_Util)
if(NOT FACETFIT_IMAGES_INCLUDE OR NOT FACETFIT_IMAGES_LIBRARY OR NOT FACETFIT_IMAGES_UTIL_LIBRARY)
  message(FATAL_ERROR "OpenImageIO is missing (libopenimageio-dev); -DFACETFIT_IMAGES=OFF builds without image stacks")
endif()
set(FACETFIT_IMAGES_LIBRARIES ${FACETFIT_IMAGES_LIBRARY} ${FACETFIT_IMAGES_UTIL_LIBRARY})
mark_as_advanced(FACETFIT_IMAGES_INCLUDE FACETFIT_IMAGES_LIBRARY FACETFIT_IMAGES_UTIL_LIBRARY)
