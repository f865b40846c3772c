{% if example %}
option({{ name }}_EXAMPLE "Build {{ name }}_controller, and run it as a test" OFF)
if({{ name }}_EXAMPLE)
  enable_testing()
  add_executable({{ name }}_controller example/{{ name }}_controller.c)
  target_link_libraries({{ name }}_controller PRIVATE {{ name }}::{{ name }})
  add_test(NAME {{ name }}_controller COMMAND {{ name }}_controller)
endif()
{% endif %}
{% if "fmu" in backends %}

option({{ name }}_FMU "Build {{ name }}.fmu, of the Functional Mock-up Interface 2.0" OFF)
if({{ name }}_FMU)
  add_subdirectory(fmu)
endif()
{% endif %}
