# Completion of the programs for bash and zsh, written from their --help: in BUILD/completions, and by `cmake --install` where
# the shells look for it. Instrumented programs complete nothing.
find_package(Python3 COMPONENTS Interpreter)
if(NOT Python3_FOUND OR HYBRID_SANITIZE OR HYBRID_FUZZ)
  return()
endif()

set(HYBRID_COMPLETIONS ${PROJECT_BINARY_DIR}/completions)
set(zsh_dir ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
if(HYBRID_PACKAGES)
  set(zsh_dir ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)  # as in Debian's packages
endif()
set(outputs)
foreach(app ${HYBRID_APPS})
  set(bash ${HYBRID_COMPLETIONS}/bash/${app})
  set(zsh ${HYBRID_COMPLETIONS}/zsh/_${app})
  add_custom_command(
    OUTPUT ${bash} ${zsh}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${HYBRID_COMPLETIONS}/bash ${HYBRID_COMPLETIONS}/zsh
    COMMAND ${Python3_EXECUTABLE} -B ${PROJECT_SOURCE_DIR}/scripts/completion.py $<TARGET_FILE:${app}> ${bash} ${zsh}
    DEPENDS ${app} ${PROJECT_SOURCE_DIR}/scripts/completion.py
    COMMENT "Completion of ${app}" VERBATIM)
  list(APPEND outputs ${bash} ${zsh})
  # Optional: a part of the programs may be built and installed.
  install(FILES ${bash} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT hybrid-apps OPTIONAL)
  install(FILES ${zsh} DESTINATION ${zsh_dir} COMPONENT hybrid-apps OPTIONAL)
endforeach()
add_custom_target(hybrid_completions ALL DEPENDS ${outputs})
