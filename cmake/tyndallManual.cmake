# Manual pages and completion, written by the command line tool itself from the tables that it parses options by; those of
# tools/ are among them where they are built.
if(NOT tyndall_sanitizers AND NOT CMAKE_CROSSCOMPILING)
  set(manual_programs tyndall_cli)
  if(TYNDALL_TOOLS)
    list(APPEND manual_programs tyndall_bench tyndall_figure)
  endif()
  file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/man1")
  add_custom_command(OUTPUT "${PROJECT_BINARY_DIR}/man1/tyndall.1"
    COMMAND tyndall_cli help --man "${PROJECT_BINARY_DIR}/man1" DEPENDS ${manual_programs} VERBATIM)
  add_custom_target(tyndall_man ALL DEPENDS "${PROJECT_BINARY_DIR}/man1/tyndall.1")
  install(DIRECTORY "${PROJECT_BINARY_DIR}/man1" DESTINATION "${CMAKE_INSTALL_MANDIR}" COMPONENT tool
    FILES_MATCHING PATTERN "*.1")
  file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/completion")
  add_custom_command(OUTPUT "${PROJECT_BINARY_DIR}/completion/tyndall"
    COMMAND tyndall_cli help --completion bash > "${PROJECT_BINARY_DIR}/completion/tyndall"
    DEPENDS ${manual_programs} VERBATIM)
  add_custom_target(tyndall_completion ALL DEPENDS "${PROJECT_BINARY_DIR}/completion/tyndall")
  install(DIRECTORY "${PROJECT_BINARY_DIR}/completion/"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT tool)
endif()
