# Runs the script and compares what it prints with the picture.
execute_process(COMMAND ${PYTHON} -B ${SCRIPT} OUTPUT_FILE ${OUTPUT} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${OUTPUT} ${PICTURE} RESULT_VARIABLE differs)
if(differs)
  message(FATAL_ERROR "the rooms have changed: scripts/draw_rooms.py > docs/images/rooms.svg")
endif()
