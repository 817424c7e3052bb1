"""Study of learned methods: a plan of trainings, which are made and evaluated."""
