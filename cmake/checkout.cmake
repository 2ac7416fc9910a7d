# Runs at every build: writes OUTPUT from INPUT with the result of `git describe` for the checkout SOURCE_DIR, or an
# empty text outside of a checkout. It writes only if the text differs, so that a commit recompiles one file and relinks
# the programs.
set(HYBRID_CHECKOUT "")
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE_DIR}/.git)  # ignores the checkout of a surrounding project
  execute_process(COMMAND ${GIT} describe --tags --always --dirty WORKING_DIRECTORY ${SOURCE_DIR}
                  OUTPUT_VARIABLE HYBRID_CHECKOUT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
