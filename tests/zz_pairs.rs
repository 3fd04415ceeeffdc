
use gelpad::eit::*;
use gelpad::pad::*;
use gelpad::touch::*;
use gelpad::types::*;
use gelpad::source::Noise;
use std::sync::Arc;
#[test]
fn pairs() {
    let s = shipped_pad(&std::env::var("PAD").unwrap_or("edinburgh-lattice".into())).unwrap(); let pad = Pad::from_toml(s.name, s.toml).unwrap();
    let table = Arc::new(gelpad::cache::table(&pad, |_,_|()).unwrap());
    let b = SensingBuilder::new(&pad, Method::Noser).unwrap().with_table(table);
    let model = ForwardModel::new(Mesh::of_pad(&pad, MeshSize::simulation(&pad)), &ContactModel::of_pad(&pad)).unwrap();
    let mut noise = Noise::new(60.0, std::env::var("SEED").map(|s| s.parse().unwrap()).unwrap_or(1));
    let v0 = model.solve_even(pad.background_s_per_m).unwrap().voltages(&pad.protocol);
    let mut d0 = Detector::of_pad(Arc::new(b.first().unwrap()), &pad.protocol);
    let mut ch = vec![];
    for k in 0..30u64 { d0.frame(&Frame{t_ns:k*10_000_000, volts: noise.read(&v0)}, &mut ch); }
    let mut seed = 4242u64 + std::env::var("SEED").map(|s| s.parse::<u64>().unwrap()).unwrap_or(1);
    let mut rnd = move || { seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); (seed>>33) as f64 / (1u64<<31) as f64 };
    let n: usize = std::env::var("N").map(|s| s.parse().unwrap()).unwrap_or(150);
    for apart in [14.0, 16.0, 18.0, 22.0, 28.0] {
        let (mut two, mut good) = (0, 0); let mut hist=[0;5];
        for _ in 0..n {
            let a = rnd()*std::f64::consts::PI; let (dx,dy)=(a.cos()*apart/2.0, a.sin()*apart/2.0);
            let m = 8.0 + apart/2.0; let c=[m+(100.0-2.0*m)*rnd(), m+(100.0-2.0*m)*rnd()];
            let p=[[c[0]-dx,c[1]-dy],[c[0]+dx,c[1]+dy]];
            let bump=|q:[f64;2], p:[f64;2]| (1.0-((q[0]-p[0]).powi(2)+(q[1]-p[1]).powi(2))/49.0).max(0.0);
            let sigma = model.mesh().mean_over_triangles(|q| pad.background_s_per_m*(1.0+bump(q,p[0]))*(1.0+bump(q,p[1])));
            let v = model.solve(&sigma).unwrap().voltages(&pad.protocol);
            let mut d=d0.clone(); d.frame(&Frame{t_ns:300_000_000, volts: noise.read(&v)}, &mut ch);
            let t = d.state().down; hist[t.len().min(4)]+=1;
            if t.len()==2 { two+=1; let e: Vec<f64> = p.iter().map(|p| t.iter().map(|t| (t.contact.centre_mm[0]-p[0]).hypot(t.contact.centre_mm[1]-p[1])).fold(f64::INFINITY,f64::min)).collect(); if e.iter().all(|e| *e<4.5) { good+=1; } else if apart==18.0 { println!("   off {e:.1?} p {p:.0?} t {:.0?}", t.iter().map(|t| t.contact.centre_mm).collect::<Vec<_>>()); } } else if apart==18.0 { println!("   count {} p {p:.0?} t {:.0?}", t.len(), t.iter().map(|t| t.contact.centre_mm).collect::<Vec<_>>()); }
        }
        println!("apart {apart}: two {two} good {good} of {n} counts {hist:?}");
    }
    for kind in ["disc r7", "disc r9", "gauss s4", "gauss s5", "ellipse 10x6"] {
        let mut hist=[0;5]; eprintln!("KIND {kind}");
        for _ in 0..n {
            let c=[12.0+76.0*rnd(), 12.0+76.0*rnd()]; let a = rnd()*std::f64::consts::PI; let rise=0.5+1.5*rnd();
            let f=|q:[f64;2]| { let (x,y)=(q[0]-c[0],q[1]-c[1]); let (u,w)=(a.cos()*x+a.sin()*y, -a.sin()*x+a.cos()*y); let d2=x*x+y*y;
              match kind { "disc r7" => if d2<49.0 {1.0} else {0.0}, "disc r9" => if d2<81.0 {1.0} else {0.0}, "gauss s4" => (-d2/32.0).exp(), "gauss s5" => (-d2/50.0).exp(), _ => if (u/10.0).powi(2)+(w/6.0).powi(2)<1.0 {1.0} else {0.0} } };
            let sigma = model.mesh().mean_over_triangles(|q| pad.background_s_per_m*(1.0+rise*f(q)));
            let v = model.solve(&sigma).unwrap().voltages(&pad.protocol);
            let mut d=d0.clone(); d.frame(&Frame{t_ns:300_000_000, volts: noise.read(&v)}, &mut ch);
            hist[d.state().down.len().min(4)]+=1; if d.state().down.len()>1 { println!("  SPLIT at {c:.0?} angle {a:.1} rise {rise:.1}: {:.0?}", d.state().down.iter().map(|t| (t.contact.centre_mm, t.contact.force*100.0)).collect::<Vec<_>>()); }
        }
        println!("{kind}: counts {hist:?} of {n}");
    }
}
