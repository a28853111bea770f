"""x"""
def write_sweep_report(folder, plan, table): pass
