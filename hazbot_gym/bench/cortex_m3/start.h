/* Print a name and a number on the host's terminal. */
void print(const char *name, unsigned value);
