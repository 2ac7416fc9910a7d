# Files of the Debian packages in addition to installed ones: man pages by help2man, copyright and changelog of each
# package.
find_program(HELP2MAN help2man REQUIRED)
find_program(GZIP gzip REQUIRED)

# The line shown by `man -k`.
set(HYBRID_PURPOSE_hybrid-replay "map landmarks and correct the trajectory of an MRPT rawlog")
set(HYBRID_PURPOSE_hybrid-import "convert data sets of others into MRPT rawlogs")
set(HYBRID_PURPOSE_hybrid-map "show, check, export and join maps of landmarks")
set(HYBRID_PURPOSE_hybrid-pgo "optimise pose graphs whose loop closures may be false")
set(HYBRID_PURPOSE_hybrid-switching "find the modes of a switching system")
set(HYBRID_PURPOSE_hybrid-experiment "run trials over methods and seeds")
set(HYBRID_PURPOSE_hybrid-objects "estimate poses of objects from odometry and detections")
set(HYBRID_PURPOSE_hybrid-register "align two clouds of points")
set(HYBRID_PURPOSE_hybrid-simulate "simulate a rawlog with its ground truth")

set(package_dir ${PROJECT_BINARY_DIR}/package_files)
set(outputs)
foreach(app ${HYBRID_APPS})
  if(NOT HYBRID_PURPOSE_${app})
    message(FATAL_ERROR "${app} needs its line for `man -k`: HYBRID_PURPOSE_${app}")
  endif()
  set(page ${package_dir}/man1/${app}.1.gz)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${package_dir}/man1
    COMMAND ${CMAKE_COMMAND} -E env SOURCE_DATE_EPOCH=0 LC_ALL=C.UTF-8 ${HELP2MAN} --no-info --section=1 --source=hybrid
            --version-string=${PROJECT_VERSION} --name=${HYBRID_PURPOSE_${app}} --output=${package_dir}/man1/${app}.1
            $<TARGET_FILE:${app}>
    COMMAND ${GZIP} -9nf ${package_dir}/man1/${app}.1
    DEPENDS ${app}
    COMMENT "Manual of ${app}" VERBATIM)
  list(APPEND outputs ${page})
endforeach()
add_custom_target(hybrid_package_files ALL DEPENDS ${outputs})

install(DIRECTORY ${package_dir}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT hybrid-apps)

configure_file(${PROJECT_SOURCE_DIR}/LICENSE ${package_dir}/copyright COPYONLY)
execute_process(COMMAND ${GZIP} -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE ${package_dir}/changelog.gz)
function(install_package_documents package component)
  install(FILES ${package_dir}/copyright ${package_dir}/changelog.gz ${package_dir}/changelog.Debian.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endfunction()
foreach(package libhybrid0 libhybrid-dev hybrid-apps)
  install_package_documents(${package} ${package})
endforeach()
if(TARGET hybrid_python)
  install_package_documents(python3-hybrid python)
endif()
