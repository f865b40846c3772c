{% if examples %}
option({{ name }}_EXAMPLE "Build the programs in example/, and run them as tests" OFF)
if({{ name }}_EXAMPLE)
  enable_testing()
  foreach(program {{ examples|join(" ") }})
    add_executable({{ name }}_${program} example/{{ name }}_${program}.c)
    target_link_libraries({{ name }}_${program} PRIVATE {{ name }}::{{ name }})
    add_test(NAME {{ name }}_${program} COMMAND {{ name }}_${program})
  endforeach()
endif()
{% endif %}
{% if "fmu" in backends %}

option({{ name }}_FMU "Build {{ name }}.fmu, of the Functional Mock-up Interface 2.0" OFF)
if({{ name }}_FMU)
  add_subdirectory(fmu)
endif()
{% endif %}
