// Read by include_table_test.sh --self-test only, never compiled.  // wrong
