# What a mistake in a reader of other people's files can be made to do is limited by the compiler and the linker: each flag where they
# have it. tests/objects reads what was built for it. A distribution that brings some of them along itself loses nothing.
include(CheckCCompilerFlag)
include(CheckCSourceCompiles)
include(CheckLinkerFlag)
include(CheckPIESupported)
check_pie_supported()

# facetfit_harden(FLAG): compiles everything that follows with it, where C and C++ know it
function(facetfit_harden flag)
  string(MAKE_C_IDENTIFIER "FACETFIT_HAS${flag}" has)
  check_c_compiler_flag(${flag} ${has})
  if(${has})
    add_compile_options(${flag})
  endif()
endfunction()

foreach(flag -fstack-protector-strong -fstack-clash-protection)
  facetfit_harden(${flag})
endforeach()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64|i[3-6]86)$")
  facetfit_harden(-fcf-protection=full)
endif()

# Calls whose room the compiler knows are checked. It takes an optimiser; sanitizers check more, and are blind to what is replaced. A
# compiler or a package that defines it already has chosen its level.
if(NOT FACETFIT_SANITIZE AND NOT FACETFIT_COVERAGE)
  set(CMAKE_REQUIRED_FLAGS "-O2")
  check_c_source_compiles("#ifdef _FORTIFY_SOURCE\n#error there\n#endif\nint main(void) { return 0; }" FACETFIT_LACKS_FORTIFY)
  unset(CMAKE_REQUIRED_FLAGS)
  if(FACETFIT_LACKS_FORTIFY)
    set(FACETFIT_FORTIFIES ON)
    add_compile_options($<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
  endif()
endif()

# Tables of addresses are filled when the program starts, and read-only from then on; no stack can be executed.
foreach(flag relro now noexecstack)
  check_linker_flag(C LINKER:-z,${flag} FACETFIT_HAS_Z_${flag})
  if(FACETFIT_HAS_Z_${flag})
    add_link_options(LINKER:-z,${flag})
  endif()
endforeach()

# A thread that calls the library may have a small stack (ff_model.h): what is large is allocated. Sanitizers and unoptimised code
# have larger frames.
if(NOT FACETFIT_SANITIZE AND NOT FACETFIT_COVERAGE)
  check_c_compiler_flag(-Werror=frame-larger-than=32768 FACETFIT_HAS_FRAME_LIMIT)
endif()
function(facetfit_limit_frames target)
  if(FACETFIT_HAS_FRAME_LIMIT)
    target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-Werror=frame-larger-than=32768>)
  endif()
endfunction()
