{% if example %}
option({{ name }}_EXAMPLE "Build the controller in example/, and run it as a test" OFF)
if({{ name }}_EXAMPLE)
  enable_testing()
  add_executable({{ name }}_controller example/{{ name }}_controller.c)
  target_link_libraries({{ name }}_controller PRIVATE {{ name }}::{{ name }})
  add_test(NAME {{ name }}_controller COMMAND {{ name }}_controller)
endif()
{% endif %}
