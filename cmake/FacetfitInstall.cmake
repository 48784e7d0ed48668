# What others link: the target facetfit::facetfit, a CMake package and a pkg-config file, all relocatable.
include(CMakePackageConfigHelpers)
get_property(headers GLOBAL PROPERTY FACETFIT_PUBLIC_HEADERS)
install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/facetfit)
install(TARGETS facetfit EXPORT facetfit-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/facetfit)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/facetfit-config.cmake.in ${PROJECT_BINARY_DIR}/facetfit-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/facetfit-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/facetfit-config.cmake ${PROJECT_BINARY_DIR}/facetfit-config-version.cmake DESTINATION ${package_dir})
install(EXPORT facetfit-targets NAMESPACE facetfit:: DESTINATION ${package_dir})

# pkg-config: a static archive names what it needs itself.
set(FACETFIT_PC_PRIVATE "")
if(NOT BUILD_SHARED_LIBS)
  set(FACETFIT_PC_PRIVATE " -lceres -lglog -lOpenEXRCore -lexpat -lz -lstdc++ -lm -pthread")
endif()
file(RELATIVE_PATH FACETFIT_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(${CMAKE_CURRENT_LIST_DIR}/facetfit.pc.in ${PROJECT_BINARY_DIR}/facetfit.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/facetfit.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/facetfit)
