int main(void)
{
    static union {
        {{ name }}_identifier head;
        unsigned char bytes[{{ name }}_IDENTIFIER_BYTES(WINDOW)];
    } memory;
    int failed = {{ name }}_identifier_init(&memory, sizeof memory, WINDOW, {{ name }}_WINDOW_SLIDING, 1);
    printf("parameters assumed: %.1e of their norm wrong\n", wrong(ASSUMED));
    const double model = track(&memory, &failed), pd = track(NULL, &failed);
    printf("computed torque: %.2e\nPD: %.2e\nratio: %.1f\n", model, pd, pd / model);
    return failed == 0 && {{ better }} * model <= pd ? 0 : 1;
}
