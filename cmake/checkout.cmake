# Run at every build: writes OUTPUT from INPUT with what `git describe` says of the checkout SOURCE_DIR, or with nothing
# where that is none, and only if it differs. So a commit compiles one file anew and links the programs.
set(HYBRID_CHECKOUT "")
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE_DIR}/.git)  # not that of a project around this one
  execute_process(COMMAND ${GIT} describe --tags --always --dirty WORKING_DIRECTORY ${SOURCE_DIR}
                  OUTPUT_VARIABLE HYBRID_CHECKOUT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
