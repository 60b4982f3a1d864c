# Writes gb_version.f90 with the revision that is being built; run at every build, rewrites only what changed.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12
    OUTPUT_VARIABLE GENTBEAM_REVISION OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR NOT GENTBEAM_REVISION)
    set(GENTBEAM_REVISION "unknown")
endif()
configure_file(${SOURCE_DIR}/src/base/gb_version.f90.in ${OUTPUT} @ONLY)
