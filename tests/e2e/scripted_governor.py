"""A governor in lockstep (`servohil run --clock lockstep`): the same in each run, whatever the machine does."""

LOCKSTEP = ("--clock", "lockstep")
REST_P1_PSI = 30.263
TICKS = 100  # per command: lockstep.ticks


def governor(client, steps, before_each=lambda step: None):
    """Pushes P1 by where the piston is, so that a lost or a doubled answer changes all that follows. It waits for the
    last message of each answer, and returns the last answer."""
    p1, answer = REST_P1_PSI, None
    for step in range(steps):
        before_each(step)
        client.send_p1(p1)
        answer = client.until(lambda f: f.name == "SERVO_Status")
        x3 = next(f["X3"] for f in answer if f.name == "SERVO_Position")
        target = 4.0 + (0.5 if step // 20 % 2 else -0.3)
        p1 = REST_P1_PSI + 2.0 * (target - x3)
    return answer
